#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""A plan processed by three nodes of Slurm on this machine, with faults: slurm.py STEREOGRID

Sixty shards of built-in scenes, and of recorded drives where STEREOGRID_DATA names their folder. A node is killed with
everything on it, the controller is killed and started again, a shard crashes, one is out of memory, one input is
poison. The merged result equals, byte for byte, what one process makes. Prints how long each recovery took, as a table.

Root only: Slurm's own programs are started here on the loopback, with a key and a state of their own, and installed
with apt-get where they are not. Exit status 77: not possible here.
"""
import json
import os
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import support
from cluster import Cluster, require_slurm, wait_for, NODES
from support import copy_of, expect_equal, status, tool

CRASHING, STARVED = 5, 11  # shards


def make_plan(folder: Path) -> Path:
    """Sixty shards, the last of which is poison."""
    bad = folder / "bad"
    subprocess.run([support.tool_path, "-q", "simulate", "street?frames=4&width=320&height=200", "--out", bad], check=True)
    recorded = sorted(Path(os.environ["STEREOGRID_DATA"]).glob("kitti_*0*")) if "STEREOGRID_DATA" in os.environ else []
    recorded = [path for path in recorded if (path / "calib.txt").exists()]
    print(f"{len(recorded)} recorded drives")
    scenes = [f"scene:street?frames=24&seed={seed}&width=320&height=200" for seed in range(1, 31)]
    plan = folder / "plan"
    tool("plan", *scenes[:len(scenes) - 3 * len(recorded)], *recorded, bad, "--frames-per-shard", 12, "--warm-up", 6,
         "--out", plan)
    for image in (bad / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    return plan


def reference_of(plan: Path, folder: Path) -> Path:
    one = copy_of(plan, "one")
    start = time.monotonic()
    tool("run", one, "--all", "--threads", 0, expect=65)
    print(f"one process: {time.monotonic() - start:.0f} s")
    tool("merge", one, "--out", folder / "one-merged", "--runs", "--allow-missing")
    return folder / "one-merged"


def unlucky_tool(folder: Path) -> Path:
    """The program, except for two shards' first runners: one crashes, one allocates all memory."""
    path = folder / "stereogrid"
    path.write_text(f"""#!/bin/sh
case "$SLURM_ARRAY_TASK_ID.${{SLURM_RESTART_COUNT:-0}}" in
  {CRASHING}.0) sh -c 'kill -SEGV $$'; exit $? ;;
  {STARVED}.0) exec python3 -c 'import time; hog = bytearray(3 << 30); hog[::4096] = b"x" * len(hog[::4096]); time.sleep(60)' ;;
esac
exec {support.tool_path} "$@"
""", encoding="utf-8")
    path.chmod(0o755)
    return path


def done_shards(plan: Path) -> set:
    names = {path.name for path in (plan / "results").glob("*/*")}
    with open(plan / "manifest.jsonl", encoding="utf-8") as lines:
        return {shard["shard"] for shard in map(json.loads, lines) if shard["digest"][:16] in names}


def only_starved_is_left(plan: Path) -> bool:
    now = status(plan)
    return now["to_do"] == str(STARVED) and now["running"] == 0


def disturb(cluster: Cluster, plan: Path) -> list:
    """Kills a node and the controller; (what, seconds until all that they had is done)."""
    rows = []
    wait_for(lambda: len(done_shards(plan)) >= 6 and cluster.tasks_on("n2"), 300, "the first results")
    lost = set(cluster.tasks_on("n2"))
    cluster.kill("n2")
    time.sleep(2)
    cluster.kill("slurmctld")
    begun = status(plan)
    print(f"killed: a node with tasks {sorted(lost)}, and the controller, when {begun['done']} shards were done")
    controller = time.monotonic()
    cluster.start("slurmctld")
    wait_for(cluster.queued, 60, "the controller")
    rows.append(("controller killed, until it answers", time.monotonic() - controller))
    rows.append(("node killed, until its tasks are done elsewhere",
                 2 + wait_for(lambda: cluster.resume_drained() or lost <= done_shards(plan), 400, f"tasks {lost}")))
    cluster.start("n2")
    rows.append(("node started again, until it works", wait_for(lambda: cluster.tasks_on("n2") or not cluster.queued(), 300,
                                                                "the node")))
    return rows


def work_on(cluster: Cluster, plan: Path, folder: Path):
    shards = status(plan)["shards"]
    reference = reference_of(plan, folder)
    cluster.start_all()
    command = tool("submit", plan, "--engine", "slurm", "--tool", unlucky_tool(folder), "--retries", 8).stdout
    start = time.monotonic()
    subprocess.run(["sh", "-c", command], env=cluster.environment, check=True)
    rows = disturb(cluster, plan)
    # not for the queue: a task that was done when its node died waits there to be started once more
    wait_for(lambda: cluster.resume_drained() or only_starved_is_left(plan), 900, "all tasks")
    cluster.call("scancel", "--full", "-u", "root")
    # Slurm ends a job that takes too much memory as a whole, and does not queue it again: that is for a person to do
    assert status(plan)["to_do"] == str(STARVED), status(plan)
    command = tool("submit", plan, "--engine", "slurm", "--memory-mb", 1000).stdout
    again = time.monotonic()
    subprocess.run(["sh", "-c", command], env=cluster.environment, check=True)
    wait_for(lambda: cluster.resume_drained() or STARVED in done_shards(plan), 200, "the shard that was out of memory")
    rows.append(("out of memory, from the second submit on", time.monotonic() - again))
    rows.append((f"all {shards} shards, with everything that happened", time.monotonic() - start))
    found = status(plan)
    assert found["running"] == 0 and (found["done"], found["failed"]) == (shards - 1, 1), found
    log = "".join(path.read_text(errors="replace") for path in (plan / "submit-slurm" / "logs").iterdir())
    assert "egmentation" in log and "emory" in log, "the logs tell neither of the crash nor of the memory"
    tool("merge", plan, "--out", folder / "merged", "--runs", "--allow-missing")
    expect_equal(folder / "merged", reference)
    print("\n| what | s |\n|---|---|")
    for what, seconds in rows:
        print(f"| {what} | {seconds:.0f} |")


def main():
    require_slurm()
    with tempfile.TemporaryDirectory(prefix="stereogrid-slurm-") as name:
        folder = Path(name).resolve()
        support.tool_path = Path(shutil.copy(support.tool_path, folder / "tool"))  # no rebuild during the test
        cluster = Cluster(folder)
        try:
            work_on(cluster, make_plan(folder), folder)
        except BaseException:
            for log in ("slurmctld.log", "slurmctld.out", *(f"{node}.log" for node in NODES)):
                if (folder / log).exists():
                    print(f"--- {log}\n" + "\n".join((folder / log).read_text(errors="replace").splitlines()[-25:]))
            raise
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
