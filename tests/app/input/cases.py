#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs `info` and `run` on inputs of other people's forms and compares with what they hold.

    cases.py STEREOGRID [ID-PREFIX…]

The folder STEREOGRID_CASES, or shared/failing beside the repository, has the inputs and cases.json: rig, frames and the
place of a box, or the words of a refusal. Skipped where it is absent."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np


def fails_read(expect: dict, out: Path) -> str:
    """Differences of the run in `out` from `expect`; empty: none."""
    run = json.loads((out / "run.json").read_text())
    frames = [json.loads(line) for line in (out / "frames.jsonl").read_text().splitlines()]
    rig = run["rig"]
    for key in ("focal_px", "baseline_m"):
        if key in expect and abs(rig[key] / expect[key] - 1) > 0.01:
            return f"{key} is {rig[key]}, not {expect[key]}"
    for key, value in zip(("cx_px", "cy_px"), expect.get("centre_px", [])):
        if abs(rig[key] - value) > 1:
            return f"{key} is {rig[key]}, not {value}"
    if "size_px" in expect and [rig["width_px"], rig["height_px"]] != expect["size_px"]:
        return f"the size is {rig['width_px']} x {rig['height_px']}"
    if "frames" in expect and len(frames) != expect["frames"]:
        return f"{len(frames)} frames, not {expect['frames']}"
    if "first_stamp_ns" in expect and frames[0]["stamp_ns"] != expect["first_stamp_ns"]:
        return f"the first stamp is {frames[0]['stamp_ns']}"
    usable = [f for f in frames if not {"few_matches", "road_unknown"} & set(f["status"])]
    if len(usable) < expect.get("usable", 1):
        return f"{len(usable)} usable frames"
    if "pose" in expect:
        for key, value in expect["pose"].items():
            if abs(frames[-1]["pose"][key] - value) > 0.02:
                return f"{key} of the last pose is {frames[-1]['pose'][key]}"
    return fails_box(expect["box"], run["grid"], usable[0], out) if "box" in expect else ""


def fails_box(box: dict, grid: dict, frame: dict, out: Path) -> str:
    occupancy = np.load(out / "grids" / f"{frame['name']}.npz")["observed"]
    cell = grid["cell_size_m"]
    y = grid["y_min_m"] + cell * (np.arange(grid["ny"]) + 0.5)
    x = grid["x_min_m"] + cell * (np.arange(grid["nx"]) + 0.5)
    rows = (y > box["y_m"][0]) & (y < box["y_m"][1])
    expected = box["x_m"] - box.get("step_m", 0) * frame["index"]
    near = x < 2 * expected
    profile = occupancy[rows][:, near].mean(axis=0)
    peak = float(x[near][np.argmax(profile)])
    if abs(peak - expected) > max(0.05 * expected, cell):
        return f"the box is at {peak:.2f} m, not at {expected:.2f} m"
    return "" if profile.max() > 0.5 else "there is no box"


def call(*arguments: object) -> tuple[int, str]:
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True, errors="replace", check=False)
    return done.returncode, done.stdout + done.stderr


def fails(tool: str, case: dict, root: Path, out: Path) -> str:
    """Why every way in which a case may be right is wrong; empty: one is right."""
    inputs = [root / path for path in case["input"]]
    options = [root / o if (root / o).exists() and "/" in o else o for o in case["options"]]
    reasons = []
    for more in ([], case["or_options"]) if "or_options" in case else ([],):
        info_code, info_text = call(tool, "info", *inputs, *options, *more)
        run_code, run_text = call(tool, "run", *inputs, *options, *more, "--out", out / f"run{len(more)}")
        for expect in case["expect"]:
            if "refused" in expect:
                said = re.search(expect["refused"], run_text, re.I) and re.search(expect["refused"], info_text, re.I)
                forbidden = "not" in expect and re.search(expect["not"], run_text, re.I)
                reason = "" if {info_code, run_code} <= {64, 65} and said and not forbidden else "not refused so"
            elif "noticed" in expect:
                both = re.search(expect["noticed"], info_text, re.I) and re.search(expect["noticed"], run_text, re.I)
                reason = "" if both else "not noticed"
            elif run_code != 0 or info_code != 0:
                reason = f"info {info_code}, run {run_code}: {run_text.strip().splitlines()[-1:]}"
            else:
                reason = fails_read(expect["read"], out / f"run{len(more)}")
            if not reason:
                return ""
            reasons.append(reason)
    return "; ".join(reasons)


def main() -> int:
    tool, *prefixes = sys.argv[1:]
    root = Path(os.environ.get("STEREOGRID_CASES") or Path(__file__).resolve().parents[4] / "shared" / "failing")
    if not (root / "cases.json").exists():
        print("skipped: no cases on this machine (STEREOGRID_CASES)")
        return 77
    failed = 0
    cases = [c for c in json.loads((root / "cases.json").read_text()) if c["id"].startswith(tuple(prefixes or [""]))]
    for case in cases:
        with tempfile.TemporaryDirectory() as out:
            reason = fails(tool, case, root, Path(out))
        failed += bool(reason)
        print(f"{'FAILED' if reason else 'ok':6} {case['id']}: {reason or case['what']}", flush=True)
    print(f"{len(cases) - failed} of {len(cases)} cases as expected")
    return 1 if failed or not cases else 0


if __name__ == "__main__":
    sys.exit(main())
