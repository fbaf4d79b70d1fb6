# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
#
# Completion for bash: commands and options are those that the program's own --help has.
_stereogrid() {
  local current=${COMP_WORDS[COMP_CWORD]} tool=${COMP_WORDS[0]} command='' word
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ $word == -* ]] || { command=$word; break; }
  done
  local words
  if [[ $current == -* ]]; then
    words=$("$tool" ${command:+"$command"} --help 2>/dev/null | grep -oE -- '--[a-z][a-z-]+' | sort -u)
  elif [[ -z $command ]]; then
    words=$("$tool" --help 2>/dev/null | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\+\) .*/\1/p')
  else
    compopt -o default
    return
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}
complete -F _stereogrid stereogrid
