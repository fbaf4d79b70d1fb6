#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Bytes that a frame takes, as Markdown, of the input and of each kind of output.

fleet.py STEREOGRID INPUT...
fleet.py STEREOGRID --check    frames of a street and of recorded drives, where they are here (STEREOGRID_DATA), take no
                               more with `--compact --layers occupancy,velocity,age` than docs/format.md states
"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

STATED_BYTES = 60_000
CHECKED_DRIVES = ("kitti_raw0009", "kitti_raw0001", "kitti_odo04")
MESSAGES = ["--layers", "occupancy", "--compact", "--mcap-topics", "packed_grid,obstacles,odometry,status"]
KINDS = (("all layers", []), ("--compact", ["--compact"]),
         ("--compact --layers occupancy,velocity,age", ["--compact", "--layers", "occupancy,velocity,age"]),
         ("the same, --every 10", ["--compact", "--layers", "occupancy,velocity,age", "--every", "10"]),
         ("--mcap: packed_grid, obstacles, odometry, status", MESSAGES))


def bytes_below(folder: Path, pattern: str = "*") -> int:
    return sum(path.stat().st_size for path in folder.rglob(pattern) if path.is_file())


def input_bytes(path: Path) -> int:
    """Images alone, by their file names."""
    return sum(bytes_below(path, f"*.{ending}") for ending in ("png", "pgm", "jpg", "jpeg", "mcap", "db3"))


def sizes(tool: str, *inputs: str):
    print("| input | kind | frames | grids | frames.jsonl | all, bytes a frame |\n| --- | --- | --- | --- | --- | --- |")
    for path in inputs:
        for kind, words in KINDS:
            with tempfile.TemporaryDirectory() as name:
                out, mcap = Path(name) / "run", Path(name) / "run.mcap"
                more = ["--mcap", mcap] if kind.startswith("--mcap") else []
                subprocess.run([tool, "-q", "run", path, "--set", "grid.length_m=30", "--out", out, *words, *more],
                               check=True)
                frames = json.loads((out / "run.json").read_text(encoding="utf-8"))["frames"]
                count = frames["last"] - frames["first"] + 1 - frames["skipped"]
                grids, lines = bytes_below(out / "grids"), (out / "frames.jsonl").stat().st_size
                if more:
                    print(f"| {Path(path).name} | {kind} | {count} | – | – | {mcap.stat().st_size / count:.0f} |")
                else:
                    print(f"| {Path(path).name} | {kind} | {count} | {grids / count:.0f} | {lines / count:.0f} | "
                          f"{(grids + lines) / count:.0f} |")
        if Path(path).exists():
            print(f"| {Path(path).name} | the input's images | {count} | – | – | {input_bytes(Path(path)) / count:.0f} |")


def check(tool: str):
    data = Path(os.environ.get("STEREOGRID_DATA") or Path(__file__).resolve().parents[2] / "shared" / "data")
    for source in ("scene:street?width=1242&height=375&frames=20", *(str(data / name) for name in CHECKED_DRIVES)):
        if not source.startswith("scene:") and not Path(source).exists():
            print(f"skipped: {source} is not on this machine (STEREOGRID_DATA)")
            continue
        with tempfile.TemporaryDirectory() as name:
            run = Path(name) / "run"
            subprocess.run([tool, "-q", "run", source, "--frames", ":19", "--set", "grid.length_m=30", "--out", run,
                            *KINDS[2][1]], check=True)
            size = (bytes_below(run / "grids") + (run / "frames.jsonl").stat().st_size) / 20
        print(f"{source}: {size:.0f} bytes a frame")
        assert size <= STATED_BYTES, f"more than {STATED_BYTES}"


if __name__ == "__main__":
    check(sys.argv[1]) if sys.argv[2:] == ["--check"] else sizes(*sys.argv[1:])
