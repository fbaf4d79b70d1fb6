# SPDX-License-Identifier: Apache-2.0
#
# Completion for bash. The program itself answers what fits: `stereogrid __complete WORD...`.
_stereogrid() {
  local line words shown prefix text=${COMP_LINE:0:COMP_POINT}
  read -ra words <<<"$text"
  [[ $text == *' ' ]] && words+=('')
  # readline completes what follows the last : or =
  shown=${COMP_WORDS[COMP_CWORD]#[:=]}
  prefix=${words[-1]%"$shown"}
  COMPREPLY=()
  while IFS= read -r line; do
    case $line in
      :files | :folders)
        compopt -o filenames
        [[ $line == :files ]] && line=-f || line=-d
        mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen "$line" -- "$shown")
        ;;
      *)
        line=${line%%$'\t'*}
        [[ $line == *[=,:] ]] && compopt -o nospace
        COMPREPLY+=("${line#"$prefix"}")
        ;;
    esac
  done < <("${COMP_WORDS[0]}" __complete "${words[@]:1}" 2>/dev/null)
}
complete -F _stereogrid stereogrid
