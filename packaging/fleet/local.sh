#!/bin/sh
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
# A batch on this machine by xargs.
# Start: sh @FILE@
# Exit codes of a task: 0 done, 64 and 65 impossible (recorded), 70 a bug, 75 try again.
cd @FOLDER@ || exit 75
jobs=@JOBS:@
[ "$jobs" ] || jobs=$(($(nproc) / @CPUS@))
[ "$jobs" -gt 0 ] || jobs=1
xargs -P "$jobs" -n 1 sh -c '
  tries=0
  while :; do
    "$0" -q batch run "$1" --shard "$2" --threads @CPUS@; code=$?
    case $code in 0) exit 0 ;; 64|65) exit 1 ;; esac
    tries=$((tries + 1))
    [ $tries -le @RETRIES@ ] || exit 1
    sleep 1
  done' @TOOL@ @PLAN@ < tasks-@ID@.txt
code=$?
[ $code -ne 123 ] || code=65  # some tasks failed: stereogrid batch status has the reasons
exit $code
