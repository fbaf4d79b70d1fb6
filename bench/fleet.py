#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Bytes that a frame takes, as Markdown, of the input and of each kind of output: fleet.py STEREOGRID INPUT..."""
import json
import subprocess
import sys
import tempfile
from pathlib import Path


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


if __name__ == "__main__":
    sizes(*sys.argv[1:])
