#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# State of a job of Slurm for Snakemake. A controller that does not answer is no verdict. Slurm holds jobs that a node did
# not launch, as one whose controller was restarted: they are released.
state=$(scontrol show job -o "$1" 2>&1)
case $state in
  *JobState=COMPLETED*) echo success ;;
  *Reason=launch_failed_requeued_held*) scontrol release "$1" >/dev/null 2>&1; echo running ;;
  *JobState=PENDING* | *JobState=RUNNING* | *JobState=CONFIGURING* | *JobState=COMPLETING* | *JobState=SUSPENDED* | *JobState=REQUEUED*) echo running ;;
  *JobState=* | *"Invalid job id"*) echo failed ;;
  *) echo running ;;
esac
