#!/bin/sh
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
# State of a job of Slurm for Snakemake. A controller that does not answer is no verdict.
state=$(scontrol show job -o "$1" 2>&1)
case $state in
  *JobState=COMPLETED*) echo success ;;
  *JobState=PENDING* | *JobState=RUNNING* | *JobState=CONFIGURING* | *JobState=COMPLETING* | *JobState=SUSPENDED* | *JobState=REQUEUED*) echo running ;;
  *JobState=* | *"Invalid job id"*) echo failed ;;
  *) echo running ;;
esac
