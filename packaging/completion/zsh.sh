#compdef stereogrid
# SPDX-License-Identifier: Apache-2.0
#
# Completion for zsh. The program itself answers what fits: `stereogrid __complete WORD...`.
_stereogrid() {
  local line word
  local -a finished unfinished
  for line in "${(@f)$("${words[1]}" __complete "${(@Q)words[2,CURRENT]}" 2>/dev/null)}"; do
    word=${line%%$'\t'*}
    case $line in
      '') ;;
      :files) _files ;;
      :folders) _files -/ ;;
      *[=,:]$'\t'* | *[=,:]) unfinished+=("$word") ;;
      *$'\t'*) finished+=("${word//:/\\:}:${line#*$'\t'}") ;;
      *) finished+=("${word//:/\\:}") ;;
    esac
  done
  (( $#unfinished )) && compadd -S '' -- "${unfinished[@]}"
  (( $#finished )) && _describe stereogrid finished
}
if [[ $funcstack[1] == _stereogrid ]]; then _stereogrid "$@"; else compdef _stereogrid stereogrid; fi
