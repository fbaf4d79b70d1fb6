#!/bin/sh
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
# A batch by GNU parallel. Arguments are added to its options: --sshloginfile MACHINES
# Start: sh @FILE@
# Exit codes of a task: 0 done, 64 and 65 impossible (recorded, returns at once), 70 a bug, 75 try again.
cd @FOLDER@ || exit 75
if [ "$1" = --task ]; then
  exec @TOOL@ -q batch run @PLAN@ --shard "$2" --threads @CPUS@
fi
jobs=@JOBS:@
[ "$jobs" ] || jobs=$(((99 + @CPUS@) / @CPUS@))%
# paths stay out of the command, in which parallel replaces {} and {.}
exec parallel --workdir . --joblog joblog-@ID@.txt --resume-failed --retries @RETRIES@ --memfree @MEMORY_MB@M --jobs "$jobs" "$@" \
  sh parallel.sh --task :::: tasks-@ID@.txt
