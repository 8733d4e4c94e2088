# Completion of gaitcam in bash: the program itself knows its verbs, options and names; where it knows none, files.
_gaitcam() {
  mapfile -t COMPREPLY < <("${COMP_WORDS[0]}" complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
}
complete -o default -F _gaitcam gaitcam
