#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""`stereogrid batch submit`, and its files: engines.py STEREOGRID local|parallel|snakemake|slurm_alone|kubernetes

Two processes submit the same plan at once, and runners are killed. The merged result equals that of one undisturbed process,
byte for byte. slurm_alone, kubernetes: small programs replace sbatch, scontrol and kubectl. Exit status 77: the engine
is not installed.
"""
import importlib.util
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import support
from support import copy_of, drive, expect_equal, make_plan, scene, skip, status, tool

# runs the tasks of an array one after the other, again after `scontrol requeue`
SBATCH = """#!/bin/sh
for word; do
  case $word in --array=0-*) range=${word#--array=0-} ;; esac
  script=$word
done
for task in $(seq 0 "${range%%%*}"); do
  export SLURM_ARRAY_JOB_ID=$$ SLURM_ARRAY_TASK_ID=$task SLURM_RESTART_COUNT=0
  while bash "$script"; [ -e "requeue-${$}_$task" ]; do
    rm "requeue-${$}_$task"
    SLURM_RESTART_COUNT=$((SLURM_RESTART_COUNT + 1))
  done
done
"""
# its exit code ends the task at once, as Slurm does
SCONTROL = """#!/bin/sh
case $1 in
  show) echo "MaxArraySize            = 4" ;;
  requeue) touch "requeue-$2"; exit 1 ;;
esac
"""
# runs the containers of an Indexed Job one after the other
KUBECTL = f"""#!{sys.executable}
import os, subprocess, sys, yaml
assert sys.argv[1:3] == ["apply", "-f"]
spec = yaml.safe_load(open(sys.argv[3]))["spec"]
container = spec["template"]["spec"]["containers"][0]
fail = spec["podFailurePolicy"]["rules"][0]["onExitCodes"]["values"]
for index in range(spec["completions"]):
    for _ in range(spec["backoffLimitPerIndex"] + 1):
        code = subprocess.run(container["command"], cwd=container["workingDir"], check=False,
                              env=os.environ | {{"JOB_COMPLETION_INDEX": str(index)}}).returncode
        if code == 0 or code in fail:
            break
"""

NAME = "it's \"one\"  $(touch harm) `touch harm` {} {.} {#} \\t %"


def with_stand_ins(folder: Path, **programs) -> dict:
    """The environment with these programs."""
    (folder / "bin").mkdir()
    for name, text in programs.items():
        (folder / "bin" / name).write_text(text, encoding="utf-8")
        (folder / "bin" / name).chmod(0o755)
    return os.environ | {"PATH": f"{folder / 'bin'}:{os.environ['PATH']}"}


def by_engine(folder: Path, engine: str, *words, env=None):
    """`folder` has a name that shells, YAML and Python have to quote."""
    folder = folder / NAME
    bad = drive(folder / "bad", 3)
    plan = make_plan(folder, *(scene(12, seed) for seed in range(1, 7)), bad, "--frames-per-shard", 6, "--warm-up", 3)
    reference = copy_of(plan, "reference")
    for image in (bad / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    tool("run", reference, "--all", expect=65)
    tool("merge", reference, "--out", folder / "reference-merged", "--runs", "--allow-missing")
    command = tool("submit", plan, "--engine", engine, *words).stdout
    engines = [subprocess.Popen(["sh", "-c", command], env=env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                start_new_session=True) for _ in range(2)]
    killed = kill_some(plan, engines)
    print(f"{killed} runners were killed, engines ended with {[process.returncode for process in engines]}")
    # shards that were killed too often for the engine are left for the next call
    if status(plan)["to_do"]:
        tool("submit", plan, "--engine", engine, *words, "--go", expect=None, env=env)
    found = status(plan)
    assert found["done"] == 12 and found["failed"] == 1, found
    tool("merge", plan, "--out", folder / "plan-merged", "--runs", "--allow-missing")
    expect_equal(folder / "plan-merged", folder / "reference-merged")
    assert "nothing to do" in tool("submit", plan, "--engine", engine, *words, expect=64).stderr


def kill_some(plan: Path, engines: list) -> int:
    dice = random.Random(7)
    killed = 0
    while any(process.poll() is None for process in engines):
        time.sleep(dice.uniform(0.3, 1.5))
        children = runners_of(plan)
        if children and killed < 8:
            killed += 1
            try:
                os.kill(dice.choice(children), signal.SIGKILL)
            except ProcessLookupError:
                killed -= 1
    return killed


def runners_of(plan: Path) -> list:
    """Processes that work on this plan: those whose command line names it."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if words[0] == str(support.tool_path).encode() and str(plan).encode() in words and b"run" in words:
                found.append(int(entry.name))
    return found


def parallel(folder: Path):
    if not shutil.which("parallel"):
        skip("GNU parallel is not installed")
    by_engine(folder, "parallel", "--jobs", 2, "--memory-mb", 100)


def local(folder: Path):
    by_engine(folder, "local", "--jobs", 2, "--shards-per-task", 2)


def snakemake(folder: Path):
    """Its lock keeps the second one out."""
    if not shutil.which("snakemake"):
        skip("Snakemake is not installed")
    by_engine(folder, "snakemake", "--jobs", 2)


def slurm_alone(folder: Path):
    by_engine(folder, "slurm", "--jobs", 2, env=with_stand_ins(folder, sbatch=SBATCH, scontrol=SCONTROL))


def kubernetes(folder: Path):
    if not importlib.util.find_spec("yaml"):
        skip("PyYAML is not installed")
    plan = make_plan(folder, scene(4))
    assert "--image" in tool("submit", plan, "--engine", "kubernetes", expect=64).stderr
    no_utf8 = "\udcff"
    assert "--claim" in tool("submit", plan, "--engine", "kubernetes", "--image", no_utf8, expect=64).stderr
    by_engine(folder, "kubernetes", "--image", "image:1", "--claim", "claim", "--tool", support.tool_path,
              "--shards-per-task", 3, env=with_stand_ins(folder, kubectl=KUBECTL))


def main():
    case = {"local": local, "parallel": parallel, "snakemake": snakemake, "slurm_alone": slurm_alone,
            "kubernetes": kubernetes}[sys.argv[2]]
    with tempfile.TemporaryDirectory(prefix="stereogrid-batch-") as name:
        folder = Path(name).resolve()
        (folder / NAME).mkdir()
        case(folder)


if __name__ == "__main__":
    main()
