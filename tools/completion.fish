# Completion of noiseloom's commands and options in fish, taken from the program's own --help as in bash.
function __noiseloom_words
    set -l words (commandline -opc)
    if test (count $words) -eq 1
        $words[1] --help 2>/dev/null | string replace -rf '^  noiseloom ([-a-z]+)( .*)?$' '$1'
    else if string match -q -- '-*' (commandline -ct)
        $words[1] $words[2] --help 2>/dev/null | string replace -rf '^  (-[^ ]+) .*$' '$1' | string split ,
    end
end
# Commands first; behind them names of files, which fish itself proposes.
complete -c noiseloom -n 'test (count (commandline -opc)) -eq 1' -f
complete -c noiseloom -a '(__noiseloom_words)'
