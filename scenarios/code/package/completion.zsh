#compdef gaitcam
# Completion of gaitcam in zsh: the program itself knows its verbs, options and names; where it knows none, files.
local text
text=$($words[1] complete "${(@)words[2,CURRENT]}" 2>/dev/null)
if [[ -n $text ]]; then compadd -- "${(@f)text}"; else _files; fi
