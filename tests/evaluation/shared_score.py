#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The scores of `stereogrid evaluate` beside those of lidar_score.py, which lies beside the data sets (../tools) and
was written by others, on the same run: shared_score.py TOOL"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy  # noqa: F401  what lidar_score.py needs
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

DRIVES = ("kitti_odo04", "kitti_raw0009")
TOLERANCE = 1e-6


def differences(ours, theirs, where):
    for name, value in theirs.items():
        exact = isinstance(value, int)
        said = ours[name] if exact else ours[name]["value"]
        if abs(said - value) > (0 if exact else TOLERANCE):
            yield f"{where} {name}: evaluate says {said}, lidar_score.py {value}"


def scores(tool, script, drive, folder):
    run = folder / "run"
    subprocess.run([tool, "--quiet", "run", drive, "--out", run, "--frames", ":10", "--poses", "none", "--set",
                    "grid.length_m=30", "--set", "matching.disparities=128"], check=True)
    subprocess.run([tool, "--quiet", "evaluate", run, "--json", folder / "ours.json"], check=True,
                   stdout=subprocess.DEVNULL)
    subprocess.run([sys.executable, script, run, drive, "--json", folder / "theirs.json"], check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads((folder / "ours.json").read_text())["series"], json.loads((folder / "theirs.json").read_text())


def main():
    data = Path(os.environ.get("STEREOGRID_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
    script = data.parent / "tools" / "lidar_score.py"
    missing = [str(path) for path in (script, *(data / drive / "velodyne" for drive in DRIVES)) if not path.exists()]
    if missing:
        print("skipped: not on this machine (STEREOGRID_DATA):", ", ".join(missing))
        sys.exit(77)
    wrong, compared = [], 0
    for drive in DRIVES:
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = scores(sys.argv[1], script, data / drive, Path(folder))
        for key, figures in theirs.items():  # such as "observed 3-10 m"
            layer, band = key.replace(" m", "").split(" ", 1)
            wrong += differences(ours[layer]["bands"][band], figures, f"{drive} {key}")
            compared += len(figures)
    print("\n".join(wrong))
    print(f"{compared} figures compared, {len(wrong)} differ")
    sys.exit(1 if wrong or compared < 150 else 0)


if __name__ == "__main__":
    main()
