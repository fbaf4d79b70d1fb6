#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Latency of `stereogrid live` on a GStreamer pipeline that plays image pairs at 30 Hz, one line per drive, as Markdown.

live.py STEREOGRID SECONDS DRIVE... where DRIVE is LEFT,RIGHT,CALIBRATION[,POSES]: folders of PNGs, a calibration with a
size, and what --poses takes. Needs ffmpeg.
"""
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

RATE_HZ = 30


def size_of(png: Path) -> tuple:
    head = png.read_bytes()[16:24]
    return int.from_bytes(head[:4], "big"), int.from_bytes(head[4:], "big")


def side_by_side(left: Path, right: Path, raw: Path) -> None:
    inputs = [word for folder in (left, right) for word in ("-pattern_type", "glob", "-i", f"{folder}/*.png")]
    subprocess.run(["ffmpeg", "-v", "error", *inputs, "-filter_complex", "hstack", "-pix_fmt", "gray", "-f", "rawvideo",
                    str(raw)], check=True)


def value(metrics: str, name: str) -> float:
    return float(re.search(rf"^{re.escape(name)} (\S+)$", metrics, re.MULTILINE)[1])


def measure(stereogrid: str, seconds: int, left: str, right: str, calibration: str, poses: str = "odometry") -> str:
    width, height = size_of(sorted(Path(left).glob("*.png"))[0])
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        raw = Path(folder) / "pairs.raw"
        side_by_side(Path(left), Path(right), raw)
        pipeline = (f"gst:filesrc location={raw} ! rawvideoparse format=gray8 width={2 * width} height={height} "
                    f"framerate={RATE_HZ}/1")
        process = subprocess.Popen([stereogrid, "live", pipeline, "--loop", "--calibration", calibration, "--poses", poses,
                                    "--listen", ":0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        page = re.search(r"http\S+", process.stdout.readline())[0]
        time.sleep(seconds)
        metrics = urllib.request.urlopen(page + "metrics").read().decode()
        memory = re.search(r"VmRSS:\s+(\d+)", Path(f"/proc/{process.pid}/status").read_text())[1]
        process.terminate()
        process.wait()
    dropped = sum(map(float, re.findall(r"^stereogrid_frames_dropped_total\{.*\} (\S+)$", metrics, re.MULTILINE)))
    frames = value(metrics, "stereogrid_frames_total")
    median, p99 = (1000 * value(metrics, f'stereogrid_latency_seconds{{quantile="{q}"}}') for q in ("0.5", "0.99"))
    return (f"| {width} × {height} | {poses} | {frames:.0f} | {dropped:.0f} | {median:.1f} | {p99:.1f} | "
            f"{int(memory) / 1024:.0f} |")


def main() -> None:
    stereogrid, seconds, drives = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
    print("| images, px | poses | grids | not used | latency, median ms | 99 % ms | memory, MB |\n|---|---|---|---|---|---|---|")
    for drive in drives:
        print(measure(stereogrid, seconds, *drive.split(",")), flush=True)


if __name__ == "__main__":
    main()
