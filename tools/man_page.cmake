# cmake -DPROGRAM=noiseloom -DVERSION=1.2.3 -DCOMMANDS=generate,plan -DOUTPUT=noiseloom.1 -P man_page.cmake
# The manual page: what the program says of itself, its commands and its settings when it is asked for help.

function(append_help heading)
  execute_process(COMMAND ${PROGRAM} ${ARGN} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\\" "\\e" text "${text}")
  string(REPLACE "-" "\\-" text "${text}")
  # A line that begins with a point or an apostrophe would be taken for a request.
  string(PREPEND text "\n")
  string(REPLACE "\n." "\n\\&." text "${text}")
  string(REPLACE "\n'" "\n\\&'" text "${text}")
  file(APPEND ${OUTPUT} "${heading}\n.nf${text}.fi\n")
endfunction()

file(WRITE ${OUTPUT} ".TH NOISELOOM 1 \"\" \"noiseloom ${VERSION}\"\n.SH NAME\n"
     "noiseloom \\- weaves sampling\\-noise textures for renderers\n")
append_help(".SH DESCRIPTION" --help)
file(APPEND ${OUTPUT} ".SH COMMANDS\n")
string(REPLACE "," ";" COMMANDS "${COMMANDS}")
foreach(command IN LISTS COMMANDS)
  append_help(".SS ${command}" ${command} --help)
endforeach()
append_help(".SH SETTINGS OF A CONFIG" --help-config)
append_help(".SH SETTINGS OF A SCENE" render --help-scene)
