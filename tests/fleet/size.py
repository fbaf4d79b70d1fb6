#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Disk space of a frame: size.py STEREOGRID

`run --compact --layers occupancy,velocity,age` on 150 x 100 cells stays below 60 kB a frame, lines of frames.jsonl
included, on a rendered street and on recorded drives, if they are here (STEREOGRID_DATA); and NumPy reads it within the
stated errors. Exit status 77: there is no NumPy.
"""
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("SKIPPED: needs Debian's python3-numpy")
    sys.exit(77)

MOST = 60_000
STEP = {"occupancy": 1 / 256, "velocity": 1 / 16, "age_s": 1 / 64}
DRIVES = ("kitti_raw0009", "kitti_raw0001", "kitti_odo04")


def run(tool: str, source: str, out: Path, *words) -> Path:
    subprocess.run([tool, "-q", "run", source, "--out", out, "--frames", ":19", "--set", "grid.length_m=30", *words],
                   check=True)
    return out


def bytes_per_frame(folder: Path) -> float:
    grids = list((folder / "grids").iterdir())
    lines = (folder / "frames.jsonl").read_bytes()
    assert lines.count(b"\n") == len(grids) == 20, "every frame has grids and a line"
    return (sum(file.stat().st_size for file in grids) + len(lines)) / len(grids)


def check_errors(small: Path, whole: Path):
    for file in sorted((small / "grids").iterdir()):
        with np.load(file) as read, np.load(whole / "grids" / file.name) as exact:
            assert set(read.files) == set(STEP), read.files
            for name, step in STEP.items():
                assert read[name].dtype == np.float16 and read[name].shape == exact[name].shape
                known = np.isfinite(exact[name])
                assert np.array_equal(known, np.isfinite(read[name]))
                error = np.abs(read[name][known].astype(float) - exact[name][known]).max()
                assert error <= step / 2 + 1e-6, f"{file.name}: {name} is off by {error}"


def main():
    data = Path(os.environ.get("STEREOGRID_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
    sources = ["scene:street?width=1242&height=375&frames=20"]
    for name in DRIVES:
        if (data / name).exists():
            sources.append(str(data / name))
        else:
            print(f"skipped: {name} is not on this machine (STEREOGRID_DATA)")
    with tempfile.TemporaryDirectory(prefix="stereogrid-size-") as name:
        for i, source in enumerate(sources):
            layers = ["--compact", "--layers", "occupancy,velocity,age"]
            small = run(sys.argv[1], source, Path(name) / f"small{i}", *layers)
            size = bytes_per_frame(small)
            print(f"{source}: {size:.0f} bytes a frame")
            assert size <= MOST, "larger than stated (docs/format.md)"
            if i < 2:
                check_errors(small, run(sys.argv[1], source, Path(name) / f"whole{i}"))


if __name__ == "__main__":
    main()
