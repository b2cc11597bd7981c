#compdef noiseloom
# Completion of noiseloom's commands and options in zsh, taken from the program's own --help as in bash.
_noiseloom() {
  local program=${words[1]} line
  local -a found
  if (( CURRENT == 2 )); then
    found=(${(f)"$($program --help 2>/dev/null | sed -nE 's/^  noiseloom ([-a-z]+)( .*)?$/\1/p')"})
    compadd -a found
    return
  fi
  if [[ ${words[CURRENT]} == -* ]]; then
    found=(${(f)"$($program ${words[2]} --help 2>/dev/null | sed -nE 's/^  (-[^ ]+) .*$/\1/p' | tr , '\n')"})
    compadd -a found
    return
  fi
  _files
}
_noiseloom "$@"
