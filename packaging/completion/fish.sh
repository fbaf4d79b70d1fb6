# SPDX-License-Identifier: Apache-2.0
#
# Completion for fish. The program itself answers what fits: `stereogrid __complete WORD...`.
function __stereogrid_complete
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    for line in ($words[1] __complete $words[2..-1] "$current" 2>/dev/null)
        switch $line
            case :files
                __fish_complete_path "$current"
            case :folders
                __fish_complete_directories "$current"
            case '*'
                echo $line
        end
    end
end
complete -c stereogrid -f -a '(__stereogrid_complete)'
