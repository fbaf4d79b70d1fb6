#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fleets under Snakemake: fleets.py STEREOGRID CASE

Whatever happens meanwhile, the results equal those of a fleet that nothing disturbs. Exit status 77: Snakemake is missing.
"""
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from support import SIZE, command_of, configure, expect_equal, finish, require_snakemake, simulate, skip

NAME = "it's \"one\"  $(touch harm) `touch harm` {} {.} {x} \\t %"


def processes_in(results: Path) -> list:
    """Processes whose working folder it is: jobs, programs, Snakemake itself."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and os.readlink(entry / "cwd") == str(results):
                found.append((int(entry.name), (entry / "cmdline").read_bytes()))
        except OSError:
            pass
    return found


def kill(pid: int) -> int:
    try:
        os.kill(pid, signal.SIGKILL)
        return 1
    except ProcessLookupError:
        return 0


def workers_in(results: Path) -> list:
    """Programs, and the jobs around them."""
    return [pid for pid, words in processes_in(results) if b"--resume" in words and b"snakemake" not in words]


def kills(folder: Path):
    """Workers are killed at random moments, and Snakemake, whose jobs live on."""
    seed = int(os.environ.get("SEED", time.time_ns() % 1_000_000))
    print(f"SEED={seed}")
    dice = random.Random(seed)
    (folder / NAME).mkdir()
    drives = {"one": str(simulate(folder / NAME / "one", 40, 1)), "cut": {"input": f"scene:street?frames=24{SIZE}", "frames": 24}}
    config = configure(folder, drives, frames_per_job=20, warm_up=20, options="--compact")
    finish(config, folder / "reference")
    results = folder / "killed"
    results.mkdir()
    workers = snakemakes = 0
    for _ in range(3):
        process = subprocess.Popen(command_of(config, results, "--cores", "2"), stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        for _ in range(dice.randint(1, 3)):
            deadline = time.monotonic() + 20
            while not workers_in(results) and process.poll() is None and time.monotonic() < deadline:
                time.sleep(0.02)
            time.sleep(dice.uniform(0, 0.4))
            workers += sum(map(kill, workers_in(results)[:dice.randint(1, 2)]))
        snakemakes += process.poll() is None
        process.kill()
        process.wait()
        if (results / "summary.json").exists():
            break
        subprocess.run(command_of(config, results, "--unlock"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    print(f"killed: {workers} workers, Snakemake {snakemakes} times")
    assert workers and snakemakes, "nothing was disturbed"
    finish(config, results)
    finish(config, results, "check")
    expect_equal(results, folder / "reference")
    assert not list(folder.rglob("harm"))
    grid = next((results / "runs").rglob("*.npz"))
    grid.write_bytes(grid.read_bytes()[:-1])
    assert "FAILED" in finish(config, results, "check", expect=1)


def remove_results(results: Path, *names):
    for name in names:
        shutil.rmtree(results / "done" / name, ignore_errors=True)
        (results / "scores" / f"{name}.json").unlink(missing_ok=True)


def poison(folder: Path):
    """A drive that cannot be used is recorded, one that is away is not started, and mixed options are refused."""
    good, bad, away = (simulate(folder / name, 4, seed) for seed, name in enumerate(("good", "bad", "away")))
    config = configure(folder, {path.name: str(path) for path in (good, bad, away)})
    results = folder / "results"
    finish(config, folder / "reference")
    images = {image: image.read_bytes() for image in (bad / "left").iterdir()}
    for image, content in images.items():
        image.write_bytes(b"x" * len(content))
    away.rename(folder / "elsewhere")
    assert "Mount its" in finish(config, results, expect=1)
    assert sorted(path.name for path in (results / "done").iterdir()) == ["bad", "good"]
    (folder / "elsewhere").rename(away)
    finish(config, results)
    summary = json.loads((results / "summary.json").read_text(encoding="utf-8"))[""]
    assert (summary["impossible"], summary["not_scored"], summary["frames"], summary["drives"]) == (["bad"], ["bad"], 8, 3), summary
    assert "none of the left images" in json.loads((results / "scores/bad.json").read_text())["impossible"]["all"]
    for image, content in images.items():
        image.write_bytes(content)
    remove_results(results, "bad")
    finish(config, results)
    expect_equal(results, folder / "reference")
    configure(folder, {path.name: str(path) for path in (good, bad)})
    finish(config, results)
    assert json.loads((results / "summary.json").read_text(encoding="utf-8"))[""]["drives"] == 2
    configure(folder, {path.name: str(path) for path in (good, bad, away)}, options="--compact")
    assert "other options: good bad away" in finish(config, results, expect=1)
    remove_results(results, "good")
    shutil.rmtree(results / "parts" / "good")
    assert "other options: bad away" in finish(config, results, expect=1)


def disk(folder: Path):
    """A full disk: no partial result counts, and the fleet continues when there is space."""
    results = folder / "small"
    results.mkdir()
    if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", results], check=False,
                                           stderr=subprocess.DEVNULL).returncode != 0:
        skip("no tmpfs can be mounted")
    try:
        config = configure(folder, {"drive": f"scene:street?frames=12{SIZE}"}, retries=1,
                           sweep={"filter.decay_time_s": [1, 2]})
        finish(config, folder / "reference")
        said = finish(config, results, expect=1)
        assert "cannot be written" in said or "space" in said, said
        assert not (results / "summary.json").exists()
        subprocess.run(["mount", "-o", "remount,size=200m", results], check=True)
        finish(config, results)
        expect_equal(results, folder / "reference")
    finally:
        subprocess.run(["umount", "-l", results], check=True)


def main():
    require_snakemake()
    with tempfile.TemporaryDirectory(prefix="stereogrid-fleet-") as name:
        folder = Path(name).resolve()
        try:
            {"kills": kills, "poison": poison, "disk": disk}[sys.argv[2]](folder)
        finally:
            for results in folder.iterdir():
                for pid, _ in processes_in(results):
                    kill(pid)


if __name__ == "__main__":
    main()
