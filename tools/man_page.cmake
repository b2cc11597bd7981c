# cmake -DPROGRAM=noiseloom -DVERSION=1.2.3 -DFOLDER=man1 -P man_page.cmake
# The manual pages: what the program says of itself, its commands and its settings when it is asked for help. noiseloom.1 holds
# all of it, noiseloom-COMMAND.1 one command.

# Appends what the program prints to PAGE.
function(append_help page heading)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  # A line that begins with a point or an apostrophe would be taken for a request.
  string(PREPEND text "\n")
  string(REPLACE "\n." "\n\\&." text "${text}")
  string(REPLACE "\n'" "\n\\&'" text "${text}")
  file(APPEND ${page} "${heading}\n.nf${text}.fi\n")
endfunction()

function(begin_page page title name sentence)
  file(WRITE ${page} ".TH ${title} 1 \"\" \"noiseloom ${VERSION}\"\n.SH NAME\n${name} \\- ${sentence}\n")
endfunction()

# The commands with their sentences are the lines "  noiseloom COMMAND ...  SENTENCE".
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n  noiseloom [a-z][-a-z]* [^\n]*  [^\n]*" lines "${help}")

set(page ${FOLDER}/noiseloom.1)
begin_page(${page} NOISELOOM noiseloom "weaves sampling\\-noise textures for renderers")
append_help(${page} ".SH DESCRIPTION" --help)
file(APPEND ${page} ".SH COMMANDS\n")
foreach(line IN LISTS lines)
  string(REGEX REPLACE "^\n  noiseloom ([a-z][-a-z]*) .*" "\\1" command "${line}")
  string(REGEX REPLACE "^.*  +([^ ].*)$" "\\1" sentence "${line}")
  if(line MATCHES "--help")  # an option of a command that has a line of its own
    continue()
  endif()
  string(REPLACE "-" "\\-" sentence "${sentence}")
  append_help(${page} ".SS ${command}" ${command} --help)
  string(TOUPPER noiseloom-${command} title)
  begin_page(${FOLDER}/noiseloom-${command}.1 ${title} noiseloom\\-${command} "${sentence}")
  append_help(${FOLDER}/noiseloom-${command}.1 ".SH DESCRIPTION" ${command} --help)
  file(APPEND ${FOLDER}/noiseloom-${command}.1 ".SH SEE ALSO\n.BR noiseloom (1)\n")
endforeach()
append_help(${page} ".SH SETTINGS OF A CONFIG" --help-config)
append_help(${page} ".SH SETTINGS OF A SCENE" render --help-scene)
append_help(${page} ".SH SETTINGS OF A BANK" bank --help-bank)
