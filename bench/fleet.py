#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Batches in numbers, as Markdown:

fleet.py STEREOGRID shards N [FOLDER]      what planning, looking at and merging N shards costs
fleet.py STEREOGRID workers [FRAMES]       frames per second of one runner, of two, and of one process with two threads
fleet.py STEREOGRID sizes INPUT...         bytes that a frame takes: of the input, of each kind of output

shards: a plan of one endless scene, a frame a shard; the results are not worked out but made up: timing.json and
done.json of a shard that was. The least of three for status, once for plan and merge. FOLDER: where to work, on the file
system that is to be measured. workers: the machine has to have nothing else to do.
"""
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def measured(*words) -> tuple:
    """Seconds, and the most memory in MB."""
    start = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{words}: exit code {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - start, usage.ru_maxrss / 1000


def make_up_results(plan: Path, tool: str) -> None:
    subprocess.run([tool, "-q", "batch", "run", plan, "--shard", "0"], check=True)
    real = next(plan.glob("results/*/*"))
    timing = (real / "timing.json").read_bytes()
    done = json.loads((real / "done.json").read_text(encoding="utf-8"))
    done["content"] = hashlib.sha256(b"").hexdigest()
    done["files"] = [["timing.json", len(timing), hashlib.sha256(timing).hexdigest()]]
    shutil.rmtree(real)
    with open(plan / "manifest.jsonl", encoding="utf-8") as lines:
        for line in lines:
            digest = json.loads(line)["digest"]
            folder = plan / "results" / digest[:3] / digest[:16]
            os.makedirs(folder)
            (folder / "timing.json").write_bytes(timing)
            (folder / "done.json").write_text(json.dumps(done | {"digest": digest}), encoding="utf-8")


def shards(tool: str, count: int, folder: str = ""):
    with tempfile.TemporaryDirectory(dir=folder or None) as name:
        plan = Path(name) / "plan"
        scene = f"scene:street?frames={count}&width=64&height=48"
        rows = [("plan", *measured(tool, "-q", "batch", "plan", scene, "--frames-per-shard", "1", "--warm-up", "0",
                                   "--no-evaluation", "--out", str(plan)))]
        rows.append(("status, nothing done", *min(measured(tool, "batch", "status", str(plan)) for _ in range(3))))
        make_up_results(plan, tool)
        rows.append(("status, all done", *min(measured(tool, "batch", "status", str(plan)) for _ in range(3))))
        rows.append(("merge", *measured(tool, "-q", "batch", "merge", str(plan), "--out", str(Path(name) / "merged"))))
        manifest = (plan / "manifest.jsonl").stat().st_size / count
    print("| what | shards | s | µs a shard | memory, MB |\n| --- | --- | --- | --- | --- |")
    for what, seconds, memory in rows:
        print(f"| {what} | {count} | {seconds:.1f} | {1e6 * seconds / count:.0f} | {memory:.0f} |")
    print(f"\n* The manifest has {manifest:.0f} bytes a shard.")


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
        for turn in range(3):
            plan = folder / f"plan{turn}"
            run = [tool, "-q", "batch", "run", plan]
            for what, commands in (
                    ("one runner, one thread", [run + ["--shard", "0-1"]]),
                    ("two runners, a thread each", [run + ["--shard", "0"], run + ["--shard", "1"]]),
                    ("one runner, two threads", [run + ["--all", "--threads", "2"]])):
                subprocess.run([tool, "-q", "batch", "plan", folder / "drives", "--frames-per-shard", "0", "--compact",
                                "--set", "grid.length_m=30", "--no-evaluation", "--out", plan], check=True)
                seconds.setdefault(what, []).append(together(commands))
                shutil.rmtree(plan)
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
    if what == "shards":
        shards(tool, int(rest[0]), *rest[1:])
    elif what == "workers":
        workers(tool, *map(int, rest))
    else:
        sizes(tool, *rest)


if __name__ == "__main__":
    main()
