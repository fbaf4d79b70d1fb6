#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""`stereogrid batch submit` with engines that run here: engines.py STEREOGRID parallel|local

Two submit the same plan at once, and runners are killed; what is merged is what one undisturbed process leaves, byte
for byte. Exit status 77: the engine is not here.
"""
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
from support import ENVIRONMENT, copy_of, drive, expect_equal, make_plan, scene, skip, status, tool


def by_engine(folder: Path, engine: str, *words):
    bad = drive(folder / "bad", 3)
    plan = make_plan(folder, *(scene(12, seed) for seed in range(1, 7)), bad, "--frames-per-shard", 6, "--warm-up", 3)
    reference = copy_of(plan, "reference")
    for image in (bad / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    tool("run", reference, "--all", expect=65)
    tool("merge", reference, "--out", folder / "reference-merged", "--runs", "--allow-missing")
    command = tool("submit", plan, "--engine", engine, *words).stdout
    engines = [subprocess.Popen(["sh", "-c", command], env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL, start_new_session=True) for _ in range(2)]
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
    print(f"{killed} runners were killed, engines ended with {[process.returncode for process in engines]}")
    # what was killed too often for the engine is left for the next call; for a while it looks as if it were worked on
    end = time.monotonic() + 120
    while status(plan)["running"] and time.monotonic() < end:
        time.sleep(0.5)
    if status(plan)["to_do"]:
        tool("submit", plan, "--engine", engine, *words, "--go", expect=None)
    found = status(plan)
    assert found["done"] == 12 and found["failed"] == 1, found
    tool("merge", plan, "--out", folder / "plan-merged", "--runs", "--allow-missing")
    expect_equal(folder / "plan-merged", folder / "reference-merged")
    assert "nothing to do" in tool("submit", plan, "--engine", engine, expect=64).stderr


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


def main():
    case = {"parallel": parallel, "local": local}[sys.argv[2]]
    with tempfile.TemporaryDirectory(prefix="stereogrid-batch-") as folder:
        case(Path(folder).resolve())


if __name__ == "__main__":
    main()
