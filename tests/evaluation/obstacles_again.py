#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the tool on a rendered sequence and on drives with labelled boxes, lets it evaluate the runs, and compares what it
says of obstacles with obstacles_score.py, the script that defined these scores: obstacles_again.py TOOL

Runs may lack the outlines of obstacles: a second comparison puts some into the runs' files."""
import json
import math
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy  # noqa: F401  the script needs it
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

# input, cells ahead as in its truth, last frame
INPUTS = (("synthetic/B-crossing", 20, 24), ("kitti_raw0009", 30, 20), ("kitti_raw0001", 30, 19))
NAMES = ("separate", "things", "free_covered", "moving_wrong", "moving", "speed_error_mps", "area_median_m2",
         "area_p90_m2")
CLOSE = 1e-6


def octagon(obstacle):
    c, s = math.cos(obstacle["yaw_rad"]), math.sin(obstacle["yaw_rad"])
    length, width = obstacle["length_m"] / 2, obstacle["width_m"] / 2
    points = [(length * math.cos(a), width * math.sin(a)) for a in (math.pi * k / 4 for k in range(8))]
    return [[obstacle["x_m"] + c * p - s * q, obstacle["y_m"] + s * p + c * q] for p, q in points]


def give_outlines(run):
    """Every obstacle an octagon, every fifth an open line, some marked as moving."""
    lines = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    for line in lines:
        for obstacle in line["obstacles"]:
            extended = obstacle["id"] % 5 == 0
            obstacle["outline_m"] = octagon(obstacle)[:5 if extended else 8]
            obstacle["kind"] = "boundary" if extended else "object"
            obstacle["moving"] = obstacle["id"] % 7 == 0
    (run / "frames.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))


def differences(said, again, where):
    for name in NAMES:
        ours, theirs = said[name], again[name]
        if (ours is None) != (theirs is None) or (ours is not None and abs(ours - theirs) > CLOSE):
            yield f"{where} {name}: the tool says {ours}, the script {theirs}"
    kinds = {kind: (round(counts["separate"], 3), counts["things"]) for kind, counts in said["by_kind"].items()}
    if kinds != {kind: tuple(counts) for kind, counts in again["by_kind"].items()}:
        yield f"{where} by kind: the tool says {kinds}, the script {again['by_kind']}"


def compare(tool, script, run, data, folder, where):
    ours, theirs = folder / "ours.json", folder / "theirs.json"
    subprocess.run([tool, "--quiet", "evaluate", run, "--json", ours], check=True, stdout=subprocess.DEVNULL)
    subprocess.run([sys.executable, script, run, data, "--json", theirs], check=True, stdout=subprocess.DEVNULL)
    again = json.loads(theirs.read_text())
    print(where, {name: again[name] for name in NAMES})
    return list(differences(json.loads(ours.read_text())["obstacles"], again, where))


def main():
    tool = sys.argv[1]
    data = Path(os.environ.get("STEREOGRID_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
    script = data.parent / "tools" / "obstacles_score.py"
    if not script.exists() or not all((data / name).is_dir() for name, _, _ in INPUTS):
        print("skipped: the script or the data sets are not on this machine (STEREOGRID_DATA)")
        sys.exit(77)
    wrong = []
    for name, length, last in INPUTS:
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            run = folder / "run"
            mounted = []
            if (calibration := data / name / "calib.txt").exists():  # the script's labels are of a level camera
                (folder / "calibration.yaml").write_text(f"from: {calibration}\nmount: {{camera_height_m: 1.65}}\n")
                mounted = ["--calibration", folder / "calibration.yaml"]
            subprocess.run([tool, "--quiet", "run", data / name, *mounted, "--out", run, "--frames", f":{last}", "--set",
                            f"grid.length_m={length}"], check=True)
            wrong += compare(tool, script, run, data / name, folder, name)
            give_outlines(run)
            wrong += compare(tool, script, run, data / name, folder, name + " with outlines")
    print("\n".join(wrong))
    print(f"{len(wrong)} figures differ")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
