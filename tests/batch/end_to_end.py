#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The contract of `stereogrid batch` against the program itself: end_to_end.py STEREOGRID CASE

A case makes a plan of built-in scenes, works on it in some unfriendly way, and expects what one undisturbed process
leaves, byte for byte. Exit status 77: the case needs something that is not here.
"""
import json
import math
import os
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import support
from support import copy_of, drive, expect_equal, make_plan, scene, skip, status, tool


def runner(plan: Path, *words) -> subprocess.Popen:
    return subprocess.Popen([str(support.tool_path), "batch", "run", str(plan), *map(str, words)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def merged(plan: Path) -> Path:
    out = Path(f"{plan}-merged")
    tool("merge", plan, "--out", out, "--runs")
    return out


def expect_clean(plan: Path):
    left = [path for path in (plan / "work").rglob("*") if path.is_file()]
    assert not left, f"left in work/: {left}"


def undisturbed(plan: Path) -> Path:
    reference = copy_of(plan, "reference")
    tool("run", reference, "--all")
    expect_clean(reference)
    return merged(reference)


def contract(folder: Path):
    plan = make_plan(folder, scene(6), scene(6, 2), "--frames-per-shard", 3, "--warm-up", 2)
    reference = undisturbed(plan)
    assert tool("status", plan, "--print-missing").stdout == "0-3\n"
    for shard in (1, 0, 3, 2):
        printed = tool("run", plan, "--shard", shard).stdout
        assert printed.startswith(f"shard {shard}: 3 frames"), printed
        assert tool("run", plan, "--shard", shard).stdout == "", "a shard that is done is processed again"
    tool("run", plan, expect=64)
    tool("run", plan, "--shard", 4, expect=64)
    expect_equal(merged(plan), reference)
    expect_clean(plan)
    # files gone or changed
    grid = next((plan / "results").rglob("000000.npz"))
    content = grid.read_bytes()
    grid.unlink()
    said = tool("merge", plan, "--out", folder / "again", expect=65).stderr
    assert "000000.npz is missing" in said, said
    # a new file: in the merged folder is a link to the one there was
    grid.write_bytes(content[:-1] + b"?")
    assert "checksum" in tool("merge", plan, "--out", folder / "again", expect=65).stderr
    shutil.rmtree(grid.parents[1])
    assert "have no result" in tool("merge", plan, "--out", folder / "again", expect=65).stderr
    tool("run", plan, "--all")
    shutil.rmtree(folder / "plan-merged")
    expect_equal(merged(plan), reference)
    # a result without its done.json is none
    done = next((plan / "results").rglob("done.json"))
    done.unlink()
    tool("run", plan, "--all")
    shutil.rmtree(folder / "plan-merged")
    expect_equal(merged(plan), reference)
    # another version's plan
    text = (plan / "plan.json").read_text(encoding="utf-8")
    (plan / "plan.json").write_text(text.replace('"version": "', '"version": "9', 1), encoding="utf-8")
    assert "make a new plan" in tool("run", plan, "--all", expect=64).stderr


def floats(npz: Path, name: str) -> list:
    with zipfile.ZipFile(npz) as archive:
        data = archive.read(f"{name}.npy")
    start = 10 + struct.unpack("<H", data[8:10])[0]
    return list(struct.unpack(f"<{(len(data) - start) // 4}f", data[start:]))


def largest_means(a: Path, b: Path, frames) -> tuple:
    """Maxima of |difference of P(occupied)|: the largest mean of a frame, and the largest share of cells above 0.15."""
    means, shares = [], []
    for frame in frames:
        grids = [floats(run / "grids" / f"{frame:06}.npz", "occupancy") for run in (a, b)]
        differences = [abs(x - y) for x, y in zip(*grids)]
        means.append(math.fsum(differences) / len(differences))
        shares.append(sum(d > 0.15 for d in differences) / len(differences))
    return max(means), max(shares)


def cut(folder: Path):
    """Effect of cutting a drive: small with a warm-up of 30 frames."""
    frames = 80
    results = {}
    for name, words in (("whole", ["--frames-per-shard", 0]), ("warm", ["--frames-per-shard", 40, "--warm-up", 30]),
                        ("cold", ["--frames-per-shard", 40, "--warm-up", 0])):
        (folder / name).mkdir()
        plan = make_plan(folder / name, scene(frames), *words)
        tool("run", plan, "--all")
        results[name] = next((merged(plan) / "runs").iterdir())
    whole = results["whole"]
    behind = range(40, frames, 3)
    mean, share = largest_means(whole, results["warm"], behind)
    cold_mean, cold_share = largest_means(whole, results["cold"], behind)
    print(f"mean |difference of P|, worst frame: {mean:.5f} with 30 frames of warm-up, {cold_mean:.5f} without;"
          f" cells that differ by more than 0.15: {share:.5f}, {cold_share:.5f}")
    assert mean < 0.004 and share < 0.003, "the stated bound (docs/fleet.md)"
    assert cold_mean > 0.02, "without a warm-up the cut has to show, or this test says nothing"


def kills(folder: Path):
    """Runners are killed at random moments, two of them at each shard; another copy of a shard is started at once."""
    seed = int(os.environ.get("SEED", time.time_ns() % 1_000_000))
    print(f"SEED={seed}")
    dice = random.Random(seed)
    plan = make_plan(folder, scene(60), scene(40, 2), "--frames-per-shard", 30, "--warm-up", 10)
    start = time.monotonic()
    reference = undisturbed(plan)
    pace = (time.monotonic() - start) / 4  # pace of a shard, on a machine with other load
    killed = 0
    for _ in range(400):
        running = [runner(plan, "--shard", dice.choice(["0-3", "2-3,0-1", "1", "3"])) for _ in range(2)]
        time.sleep(dice.uniform(0.02, pace) if dice.random() < 0.7 else dice.uniform(pace, 5 * pace))
        for process in running:
            if process.poll() is None:
                process.kill()
                killed += 1
            process.wait()
        if status(plan)["done"] == 4:
            break
    found = status(plan)
    assert found["done"] == 4 and found["failed"] == 0, found
    print(f"{killed} runners were killed")
    # runners killed after their result was in place leave their work folder; the next one removes it
    expect_equal(merged(plan), reference)
    # two at once, undisturbed
    second = copy_of(plan, "second")
    codes = {process.wait() for process in [runner(second, "--shard", "0-3"), runner(second, "--shard", "0-3")]}
    assert codes <= {0, 75}, codes
    tool("run", second, "--all")
    expect_equal(merged(second), reference)
    expect_clean(second)


def signals(folder: Path):
    """SIGTERM: exit code 75, and the next runner continues from there."""
    plan = make_plan(folder, scene(60), "--frames-per-shard", 0)
    reference = undisturbed(plan)
    stops = 0
    for _ in range(100):
        process = runner(plan, "--shard", 0)
        before = finished(plan)
        deadline = time.time() + 60
        while process.poll() is None and finished(plan) < before + 7 and time.time() < deadline:
            time.sleep(0.01)
        process.terminate()
        code = process.wait()
        if code == 0:
            break
        assert code == 75, f"exit code {code} after SIGTERM"
        stops += 1
        assert status(plan)["to_do"] in ("", "0")
        # the last frame may have come before the signal
        is_done = status(plan)["done"] == 1
        assert is_done or next((plan / "work").rglob("state.npz"), None), "no state was saved"
    assert 2 <= stops < 100, f"{stops} stops"
    print(f"stopped {stops} times")
    expect_equal(merged(plan), reference)
    expect_clean(plan)


def finished(plan: Path) -> int:
    lines = next((plan / "work").rglob("run/frames.jsonl"), None) if (plan / "work").exists() else None
    try:
        return lines.read_bytes().count(b"\n") if lines else 0
    except FileNotFoundError:
        return 0


def poison(folder: Path):
    """Inputs that cannot be used end with 65, once; missing inputs with 75."""
    good, bad = drive(folder / "good", 1), drive(folder / "bad", 2)
    plan = make_plan(folder, good, bad)
    for image in (bad / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    process = tool("run", plan, "--all", expect=65)
    assert "none of the left images" in process.stderr, process.stderr
    found = status(plan)
    assert (found["done"], found["failed"], found["to_do"]) == (1, 1, ""), found
    assert found["failures"][0]["shard"] == 1
    assert "not tried again" in tool("run", plan, "--shard", 1, expect=65).stderr
    assert "1 of 2 shards have no result: 1." in tool("merge", plan, "--out", folder / "out", expect=65).stderr
    tool("merge", plan, "--out", folder / "out", "--allow-missing")
    parts = [json.loads(line) for line in (folder / "out" / "parts.jsonl").read_text(encoding="utf-8").splitlines()]
    assert parts[1]["state"] == "failed" and "none of the left images" in parts[1]["why"], parts
    assert "none of the left images" in tool("run", plan, "--shard", 1, "--retry-poison", expect=65).stderr
    # not mounted
    other = copy_of(plan, "other")
    (folder / "good").rename(folder / "elsewhere")
    assert "mounted" in tool("run", other, "--shard", 0, expect=75).stderr
    assert status(other)["failed"] == 0
    (folder / "elsewhere").rename(folder / "good")
    tool("run", other, "--shard", 0)
    # another file than when the plan was made
    changed = copy_of(plan, "changed")
    (good / "calibration.yaml").write_text((good / "calibration.yaml").read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert "has changed since the plan" in tool("run", changed, "--shard", 0, expect=65).stderr


def clocks(folder: Path):
    """Machines whose clocks differ by days."""
    if not shutil.which("faketime"):
        skip("there is no faketime")
    plan = make_plan(folder, scene(6), "--frames-per-shard", 3, "--warm-up", 2)
    reference = undisturbed(plan)
    for clock, shard in (("+2d", "0"), ("-2d", "1")):
        subprocess.run(["faketime", "-f", clock, support.tool_path, "batch", "run", plan, "--shard", shard], check=True,
                       env=os.environ | {"NO_FAKE_STAT": "1"}, stdout=subprocess.DEVNULL)
    expect_equal(merged(plan), reference)


def disk(folder: Path):
    """A disk that is full: 75, no partial result counts, and it continues once there is space."""
    plan = make_plan(folder, scene(30), "--frames-per-shard", 15, "--warm-up", 5)
    reference = undisturbed(plan)
    small = folder / "small"
    small.mkdir()
    mounted = os.geteuid() == 0 and subprocess.run(["mount", "-t", "tmpfs", "-o", "size=9m", "tmpfs", small], check=False,
                                                   stderr=subprocess.DEVNULL).returncode == 0
    try:
        target = copy_of(plan, "small/plan") if mounted else copy_of(plan, "limited")
        if mounted:
            print("on a tmpfs of 9 MB")
            said = tool("run", target, "--all", expect=75).stderr
            subprocess.run(["mount", "-o", "remount,size=200m", small], check=True)
        else:
            print("no tmpfs can be mounted: files above 300 kB cannot be written instead")
            limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, resource.RLIM_INFINITY))
            said = tool("run", target, "--all", expect=75, preexec_fn=limit).stderr
        assert "cannot be written" in said or "space" in said, said
        found = status(target)
        assert found["failed"] == 0 and found["done"] < 2, found
        tool("run", target, "--all")
        expect_equal(merged(target), reference)
        expect_clean(target)
    finally:
        if mounted:
            subprocess.run(["umount", "-l", small], check=True)


def main():
    case = {"contract": contract, "cut": cut, "kills": kills, "signals": signals, "poison": poison,
            "disk": disk, "clocks": clocks}[sys.argv[2]]
    with tempfile.TemporaryDirectory(prefix="stereogrid-batch-") as folder:
        case(Path(folder).resolve())


if __name__ == "__main__":
    main()
