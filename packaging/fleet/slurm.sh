#!/bin/bash
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
# A batch by Slurm: the script submits itself as job arrays. Arguments are added to sbatch: --partition=NAME
# Start: sh @FILE@
# Exit codes of a task: 0 done, 64 and 65 impossible (recorded), 70 a bug, 75 try again.
#SBATCH --job-name=stereogrid
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:TERM@60
#SBATCH --cpus-per-task=@CPUS@
#SBATCH --mem=@MEMORY_MB@M
#SBATCH --output=logs/%A_%a.txt
cd @FOLDER@ || exit 75

if [ -z "$STEREOGRID_FIRST_TASK" ]; then
  mkdir -p logs
  largest=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')
  at_once=@JOBS:@
  [ @GPUS@ = 0 ] || set -- --gres=gpu:@GPUS@ "$@"
  first=0
  while [ $first -lt @COUNT@ ]; do
    last=$((@COUNT@ - first - 1))
    [ $last -lt "${largest:-1001}" ] || last=$((${largest:-1001} - 1))
    STEREOGRID_FIRST_TASK=$first sbatch --export=ALL "$@" --array=0-$last${at_once:+%$at_once} slurm.sh || exit 75
    first=$((first + last + 1))
  done
  exit 0
fi

# One task. The signal is passed on, and the saved state waited for. Tasks that end with 70 or 75, or are killed, are
# queued again.
shards=$(sed -n "$((STEREOGRID_FIRST_TASK + SLURM_ARRAY_TASK_ID + 1))p" tasks-@ID@.txt)
@TOOL@ -q batch run @PLAN@ --shard "$shards" --threads @CPUS@ &
child=$!
trap 'kill -TERM $child' TERM
wait $child; code=$?
while kill -0 $child 2>/dev/null; do wait $child; code=$?; done
case $code in 70|75|13[4-9]) retry=1 ;; *) retry=0 ;; esac
if [ $retry = 1 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt @RETRIES@ ]; then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}" && sleep 60
fi
exit $code
