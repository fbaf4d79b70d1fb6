#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Cameras with many extrinsics that the calibrations lack: frame in which the extrinsics are estimated, how far off
it is, and whether any frame before has called a cell occupied. Prints a Markdown table.

    python3 research/extrinsics.py build/release/bin/stereogrid [--drives FOLDER …]

Real drives get other extrinsics by a changed calibration: a baseline of k times its length scales the camera height
by k, and a principal point that is f·tan(pitch) lower adds a pitch, since the plane in disparity space is the same.
Errors are relative to the drive's own calibration.
"""
import argparse
import json
import math
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

DEGREE = math.pi / 180
OCCUPIED = 0.7  # threshold of the observed grid, clearly above unknown
MOUNTS = [(0, 1.0), (0, 1.3), (0, 2.6), (4, 1.65), (4, 1.2), (8, 1.65), (8, 1.0), (10, 1.2), (10, 2.0), (20, 1.2), (20, 2.6)]
SMALL = "width=512&height=320"
WIDE = "width=1242&height=375"
CASES = (
    [("street", WIDE, pitch, height) for pitch, height in MOUNTS]
    + [("street", SMALL, pitch, height) for pitch, height in MOUNTS + [(0, 0.4), (8, 0.4), (10, 0.6)]]
    + [("crossing", SMALL, pitch, height) for pitch, height in MOUNTS[3:]]
    + [("street", SMALL + "&baseline=0.06&focal=300", pitch, height) for pitch, height in [(0, 0.28), (12.5, 0.28), (20, 0.4)]]
)
DRIVES = [(0, 0.4), (0, 1.0), (0, 2.6), (4, 1.0), (8, 1.65), (8, 0.6), (10, 1.2), (10, 2.0)]
LINE = re.compile(r"camera_height_m: ([-\d.]+), camera_pitch_rad: ([-\d.]+), camera_roll_rad: ([-\d.]+)")


def simulate(tool: str, scene: str, folder: Path, frames: int) -> None:
    subprocess.run([tool, "simulate", scene, "--out", folder, "--frames", str(frames), "--no-truth"], check=True,
                   capture_output=True)
    calibration = folder / "calibration.yaml"
    kept = [line for line in calibration.read_text().splitlines() if not line.startswith("mount")]
    calibration.write_text("\n".join(kept) + "\n")


def frames_of(run: Path) -> list:
    return [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]


def judge(run: Path, pitch_deg: float, height_m: float) -> str:
    """The row's last columns: first frame that is used, errors of the extrinsics, status of the frames before."""
    frames = frames_of(run)
    found = None
    for i, frame in enumerate(frames):
        for warning in frame["warnings"]:
            match = LINE.search(warning)
            if match:
                found = (i + 1, *map(float, match.groups()))
    used = [i for i, frame in enumerate(frames) if not {"road_unknown", "few_matches"} & set(frame["status"])]
    until = found[0] if found else 0 if used else len(frames)
    occupied = sum(
        int((np.load(run / "grids" / f"{frame['name']}.npz")["observed"] > OCCUPIED).any()) for frame in frames[:until])
    if found is None:
        ground = frames[used[-1]]["ground"] if used else None
        if ground is None:
            return f"never | | | {occupied}"
        return (f"fits ({used[0]}) | {ground['height_m'] - height_m:+.3f} | "
                f"{ground['pitch_rad'] / DEGREE - pitch_deg:+.2f} | 0")
    lost = sum(1 for frame in frames[until:] if {"road_unknown", "few_matches"} & set(frame["status"]))
    return (f"{found[0]} | {found[1] - height_m:+.3f} | {found[2] / DEGREE - pitch_deg:+.2f} | {occupied}"
            + (f" ({lost} of {len(frames) - until} later ones unknown)" if lost else ""))


def run_on(tool: str, recording: Path, run: Path, *more: object) -> None:
    subprocess.run(["rm", "-rf", run], check=True)
    subprocess.run([tool, "run", recording, "--out", run, "--device", "cpu", "--quiet", *map(str, more)], check=True,
                   capture_output=True)


def measure_drive(tool: str, drive: Path, root: Path, frames: int) -> None:
    run, calibration = root / "run", root / "calibration.yaml"
    run_on(tool, drive, run, "--frames", f":{frames - 1}")
    rig = json.loads((run / "run.json").read_text())["rig"]
    grounds = [frame["ground"] for frame in frames_of(run)]
    own_height = float(np.median([ground["height_m"] for ground in grounds]))
    own_pitch = float(np.median([ground["pitch_rad"] for ground in grounds]))
    print(f"| {drive.name}, its own | {own_pitch / DEGREE:.2f} | {own_height:.3f} | "
          f"{judge(run, own_pitch / DEGREE, own_height)} |", flush=True)
    for pitch_deg, height_m in DRIVES:
        down = rig["focal_px"] * math.tan(pitch_deg * DEGREE)
        pitch = math.atan(math.tan(own_pitch) + math.tan(pitch_deg * DEGREE))
        scale = height_m / (own_height * math.cos(pitch) / math.cos(own_pitch))
        calibration.write_text(
            f"focal_px: {rig['focal_px']}\ncx_px: {rig['cx_px']}\n"
            f"cy_px: {rig['cy_px'] + down}\nbaseline_m: {rig['baseline_m'] * scale}\n")
        run_on(tool, drive, run, "--calibration", calibration, "--poses", "none", "--frames", f":{frames - 1}")
        print(f"| {drive.name} | {pitch / DEGREE:.2f} | {height_m} | {judge(run, pitch / DEGREE, height_m)} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--only", default="", help="cases whose scene contains this")
    parser.add_argument("--keep", type=Path, help="folder for the scenes and runs")
    parser.add_argument("--drives", type=Path, nargs="*", default=[])
    arguments = parser.parse_args()
    print("| scene | pitch [deg] | height [m] | first frame used | height error [m] | pitch error [deg] | "
          "frames before with occupied cells |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        root = arguments.keep or Path(temporary)
        for number, (name, settings, pitch_deg, height_m) in enumerate(CASES):
            scene = f"scene:{name}?{settings}&pitch_deg={pitch_deg}&camera_height={height_m}"
            if arguments.only not in scene:
                continue
            recording, run = root / f"scene{number}", root / f"run{number}"
            if not recording.exists():
                simulate(arguments.tool, scene, recording, arguments.frames)
            run_on(arguments.tool, recording, run)
            print(f"| {name}, {settings.replace('&', ', ')} | {pitch_deg} | {height_m} | {judge(run, pitch_deg, height_m)} |",
                  flush=True)
        for drive in arguments.drives:
            measure_drive(arguments.tool, drive, root, arguments.frames)


if __name__ == "__main__":
    main()
