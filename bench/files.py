#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""From files to files, as Markdown: frames per second of `stereogrid run`, start of the program included.

files.py STEREOGRID DRIVE [FRAMES]

DRIVE: a KITTI odometry sequence with poses_gt.txt. It is driven to and fro until there are FRAMES (400), so that the
start does not count for more than it does in a drive. The least of three turns of each way, one after the other.
"""
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

WAYS = (("all layers", []), ("--compact", ["--compact"]), ("all layers, --poses odometry", ["--poses", "odometry"]))


def to_and_fro(drive: Path, frames: int, folder: Path) -> None:
    names = sorted(path.name for path in (drive / "image_0").iterdir())
    there_and_back = [*range(len(names)), *range(len(names) - 2, 0, -1)]
    order = [there_and_back[i % len(there_and_back)] for i in range(frames)]
    poses = (drive / "poses_gt.txt").read_text(encoding="utf-8").splitlines()
    for camera in ("image_0", "image_1"):
        (folder / camera).mkdir(parents=True)
        for i, source in enumerate(order):
            (folder / camera / f"{i:06d}.png").symlink_to(drive / camera / names[source])
    (folder / "calib.txt").symlink_to(drive / "calib.txt")
    (folder / "poses_gt.txt").write_text("".join(poses[i] + "\n" for i in order), encoding="utf-8")
    (folder / "times.txt").write_text("".join(f"{0.1 * i:.1f}\n" for i in range(frames)), encoding="utf-8")


def measured(words: list) -> tuple:
    """Seconds, and of processors."""
    start = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{words}: exit code {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - start, usage.ru_utime + usage.ru_stime


def main():
    tool, drive, frames = sys.argv[1], Path(sys.argv[2]).resolve(), int(sys.argv[3]) if len(sys.argv) > 3 else 400
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        to_and_fro(drive, frames, folder / "drive")
        turns = {what: [] for what, _ in WAYS}
        for turn in range(3):
            for what, options in WAYS:
                out = folder / f"{what} {turn}"
                turns[what].append(measured([tool, "-q", "run", folder / "drive", "--threads", "2", "--out", out, *options]))
    print("| what is written | frames | frames a second | processor ms a frame |\n| --- | --- | --- | --- |")
    for what, taken in turns.items():
        seconds, processor_s = min(taken)
        print(f"| {what} | {frames} | {frames / seconds:.1f} | {1000 * processor_s / frames:.1f} |")


if __name__ == "__main__":
    main()
