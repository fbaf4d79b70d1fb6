#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A fleet under Snakemake on three nodes of Slurm on this machine, with faults: slurm.py STEREOGRID

A node is killed with everything on it, the controller is killed and started again, a job crashes. The results equal those
of a fleet on this machine that nothing disturbs.

Root only: Slurm's own programs are started here on the loopback, with a key and a state of their own, and installed
with apt-get where they are not. Exit status 77: not possible here.
"""
import subprocess
import tempfile
import time
from pathlib import Path

from cluster import NODES, Cluster, require_slurm, wait_for
from support import SIZE, TOOL, command_of, configure, expect_equal, finish, require_snakemake


def unlucky_tool(folder: Path) -> Path:
    """The program, but the first run of a drive crashes."""
    path = folder / "stereogrid"
    path.write_text(f'#!/bin/sh\ncase "$*" in *seed=5*) mkdir {folder}/crashed 2>/dev/null && kill -SEGV $$ ;; esac\n'
                    f'exec {TOOL} "$@"\n', encoding="utf-8")
    path.chmod(0o755)
    return path


def done(results: Path) -> int:
    return len(list((results / "done").rglob("all")))


def disturb(cluster: Cluster, results: Path, snakemake: subprocess.Popen):
    """Kills a node and the controller while drives are processed."""
    wait_for(lambda: done(results) >= 2 and cluster.jobs_on("n2"), 300, "the first drives")
    cluster.kill("n2")
    time.sleep(2)
    cluster.kill("slurmctld")
    print(f"killed: a node and the controller, when {done(results)} drives were done")
    time.sleep(3)
    cluster.start("slurmctld")
    wait_for(lambda: cluster.resume_drained() or snakemake.poll() is not None, 600, "Snakemake")


def work_on(cluster: Cluster, folder: Path):
    drives = {f"d{seed}": f"scene:street?frames=60&seed={seed}{SIZE}" for seed in range(1, 13)}
    results = folder / "results"
    finish(configure(folder, drives), folder / "reference")
    config = configure(folder, drives, tool=str(unlucky_tool(folder)), memory_mb=300)
    cluster.start_all()
    with open(folder / "snakemake.log", "wb") as log:
        snakemake = subprocess.Popen(command_of(config, results, profile="slurm"), env=cluster.environment, stdout=log, stderr=log)
        disturb(cluster, results, snakemake)
    said = (folder / "snakemake.log").read_text(errors="replace")
    assert snakemake.wait() == 0, said
    assert (folder / "crashed").exists()
    expect_equal(results, folder / "reference")


def main():
    require_snakemake()
    require_slurm()
    with tempfile.TemporaryDirectory(prefix="stereogrid-slurm-") as name:
        folder = Path(name).resolve()
        cluster = Cluster(folder)
        try:
            work_on(cluster, folder)
        except BaseException:
            for log in ("slurmctld.log", "slurmctld.out", "snakemake.log", *(f"{node}.log" for node in NODES)):
                if (folder / log).exists():
                    print(f"--- {log}\n" + "\n".join((folder / log).read_text(errors="replace").splitlines()[-25:]))
            raise
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
