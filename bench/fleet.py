#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Fleets in numbers, as Markdown:

fleet.py STEREOGRID workers [FRAMES]       frames per second of one run, of two at once, and of one with two threads
fleet.py STEREOGRID sizes INPUT...         bytes that a frame takes: of the input, of each kind of output

workers: the machine has to have nothing else to do.
"""
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def together(commands: list) -> float:
    """Seconds until all have ended."""
    start = time.monotonic()
    processes = [subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL) for command in commands]
    for process, command in zip(processes, commands):
        if process.wait() != 0:
            sys.exit(f"{command}: exit code {process.returncode}")
    return time.monotonic() - start


def workers(tool: str, frames: int = 200):
    """Two drives; the least of three turns of each way, one after the other. Rendering them is not measured."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for drive in ("one", "two"):
            subprocess.run([tool, "-q", "simulate", f"street?frames={frames}&width=1242&height=375", "--out",
                            folder / "drives" / drive, "--no-truth"], check=True, stdout=subprocess.DEVNULL)
        seconds = {}
        for _ in range(3):
            def run(drive: str, threads: int) -> list:
                return [tool, "-q", "run", folder / "drives" / drive, "--out", folder / "run" / drive, "--compact", "--set",
                        "grid.length_m=30", "--threads", threads]
            for what, groups in (("one runner, one thread", [[run("one", 1)], [run("two", 1)]]),
                                 ("two runners, a thread each", [[run("one", 1), run("two", 1)]]),
                                 ("one runner, two threads", [[run("one", 2)], [run("two", 2)]])):
                seconds.setdefault(what, []).append(sum(map(together, groups)))
                shutil.rmtree(folder / "run")
    print("| who works | frames a second | frames a second and core |\n| --- | --- | --- |")
    for what, turns in seconds.items():
        speed = 2 * frames / min(turns)
        print(f"| {what} | {speed:.2f} | {speed / (1 if what.startswith('one runner, one') else 2):.2f} |")


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


def main():
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    tool, what, *rest = sys.argv[1:]
    if what == "workers":
        workers(tool, *map(int, rest))
    else:
        sizes(tool, *rest)


if __name__ == "__main__":
    main()
