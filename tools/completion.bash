# Completion of noiseloom's commands and options in bash. They are taken from the program's own --help, so that they are
# always those of the program that is installed.
_noiseloom() {
  local word=${COMP_WORDS[COMP_CWORD]} words=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    words=$("$1" --help 2>/dev/null | sed -nE 's/^  noiseloom ([-a-z]+)( .*)?$/\1/p')
  elif [[ $word == -* ]]; then
    words=$("$1" "${COMP_WORDS[1]}" --help 2>/dev/null | sed -nE 's/^  (-[^ ]+) .*$/\1/p' | tr , '\n')
  fi
  [ -z "$words" ] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}
# Where nothing is proposed, names of files are.
complete -o bashdefault -o default -F _noiseloom noiseloom
