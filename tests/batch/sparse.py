#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Batches of which a part is written, --every and --layers: sparse.py STEREOGRID

Which frames are written does not depend on how drives are cut, nor on runners that are stopped between such frames.
"""
import json
import random
import subprocess
import tempfile
import time
from pathlib import Path

import support
from support import copy_of, expect_equal, make_plan, scene, status, tool

FRAMES, EVERY = 80, 7
SMALL = ["--every", EVERY, "--compact", "--layers", "occupancy,velocity,age", "--no-evaluation"]


def merged(plan: Path) -> Path:
    out = Path(f"{plan}-merged")
    tool("merge", plan, "--out", out, "--runs")
    return out


def done(folder: Path, name: str, *words) -> Path:
    (folder / name).mkdir()
    plan = make_plan(folder / name, scene(FRAMES), *words)
    tool("run", plan, "--all")
    return plan


def expect_every_frame(merge: Path):
    run = next((merge / "runs").iterdir())
    names = sorted(str(path.relative_to(run)) for path in run.rglob("*.npz"))
    assert names == [f"grids/{i:06}.npz" for i in range(0, FRAMES, EVERY)], names
    lines = [json.loads(line)["name"] for line in (run / "frames.jsonl").read_text(encoding="utf-8").splitlines()]
    assert [f"grids/{name}.npz" for name in lines] == names, lines


def stopped(plan: Path, reference: Path):
    """SIGTERM at any moment: finished frames are kept, also between written frames."""
    dice = random.Random(7)
    stops = 0
    for _ in range(60):
        process = subprocess.Popen([str(support.tool_path), "batch", "run", str(plan), "--all"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(dice.uniform(0.3, 1.5))
        process.terminate()
        if process.wait() == 0:
            break
        stops += 1
    assert stops > 1, "it was too fast to be stopped"
    tool("run", plan, "--all")
    expect_equal(merged(plan), reference)
    print(f"stopped {stops} times")


def main():
    with tempfile.TemporaryDirectory(prefix="stereogrid-sparse-") as name:
        folder = Path(name).resolve()
        whole = done(folder, "whole", "--frames-per-shard", 0, *SMALL)
        # shards in which nothing is written, too
        short = done(folder, "short", "--frames-per-shard", 5, "--warm-up", 2, *SMALL)
        run = json.loads((next((merged(whole) / "runs").iterdir()) / "run.json").read_text(encoding="utf-8"))
        assert (run["every"], run["layers"], run["compact"]) == (EVERY, ["occupancy", "age_s", "velocity"], True), run
        expect_every_frame(Path(f"{whole}-merged"))
        expect_every_frame(merged(short))
        found = status(short)
        assert (found["done"], found["frames_done"]) == (16, FRAMES), found
        stopped(copy_of(whole, "stopped"), Path(f"{whole}-merged"))
        # they are part of what a result is named by
        others = [done(folder, f"other{i}", "--frames-per-shard", 0, *words, "--compact", "--no-evaluation")
                  for i, words in enumerate((["--every", 20], ["--every", 20, "--layers", "occupancy"], ["--every", 21]))]
        digests = {json.loads((plan / "manifest.jsonl").read_text(encoding="utf-8"))["digest"] for plan in others}
        assert len(digests) == 3, digests


if __name__ == "__main__":
    main()
