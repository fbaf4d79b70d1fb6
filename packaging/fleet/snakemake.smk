# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
# A batch by Snakemake. More options select a profile or an executor: --executor slurm
# Start: snakemake --snakefile @FILE@ --cores @JOBS:all@ --keep-going
# Exit codes of a task: 0 done, 64 and 65 impossible (recorded, returns at once), 70 a bug, 75 try again.
workdir: @FOLDER@

with open(@FOLDER@ + "/tasks-@ID@.txt") as lines:
    tasks = lines.read().split()


rule all:
    input:
        expand("done-@ID@/{shards}", shards=tasks),


rule shards:
    output:
        touch("done-@ID@/{shards}"),
    params:
        tool=@TOOL@,
        plan=@PLAN@,
    threads: @CPUS@
    retries: @RETRIES@
    resources:
        mem_mb=@MEMORY_MB@,
        gpu=@GPUS@,
    shell:
        "{params.tool:q} -q batch run {params.plan:q} --shard {wildcards.shards} --threads {threads}"
