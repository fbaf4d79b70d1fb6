#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the runs that the paper's figures need, of a drive or a built-in scene, and draws them.

make_figures.py path/to/drive --frames 0:20 --out figures     the last frame is the one that is shown
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import figures
except ModuleNotFoundError as missing:
    sys.exit(f"Python has no {missing.name}. Install it: apt install python3-matplotlib, and use /usr/bin/python3.")

SCENE, FRAMES = "scene:street?frames=45", "2:22"  # a person steps out from behind a parked car
BUILT = Path(__file__).resolve().parents[2] / "build" / "release" / "bin"
RATES, RAISED = ("false_positive", "false_negative"), 0.25  # as in the paper: one of them at a time


def settings(values):
    return [word for value in values for word in ("--set", value)]


def make_runs(source, work, programs, options):
    """Leaves the runs in the folder `work`; gives figures.draw() its arguments."""
    tool = programs / "stereogrid"

    def run(program, *words):
        return subprocess.run([program, "--quiet", *words], stdout=subprocess.DEVNULL, check=True)

    if source.startswith("scene:"):
        run(tool, "simulate", source, "--out", work / source.replace("/", "_"))
        source = work / source.replace("/", "_")
    run(tool, "run", source, "--out", work / "run", "--save-stages", *options)
    run(tool, "run", source, "--out", work / "without_gaussian", *options,
        *settings(("paper.sigma_disparity=0", "paper.sigma_column=0")))
    for rate in RATES:
        run(tool, "run", source, "--out", work / rate, *options, *settings((f"paper.{rate}={RAISED}",)))
    try:
        run(programs / "stereogrid-compare", source, "--grids", work / "compared", "--only",
            "nearest_obstacle_paper,nearest_obstacle", *options)
    except subprocess.CalledProcessError as error:
        if error.returncode != 65:  # neither lidar nor truth, as it has said: the others can be drawn
            raise
    return {"folder": work / "run", "without_gaussian": work / "without_gaussian",
            "rates": [work / rate for rate in RATES], "compared": work / "compared"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", nargs="?", help=f"a drive's folder, or a built-in scene (default: {SCENE}, {FRAMES})")
    parser.add_argument("--out", required=True, help="folder for figure_1.png and so on")
    parser.add_argument("--frames", metavar="FIRST:LAST", help="as of `stereogrid run`; the last one is shown")
    parser.add_argument("--preset", default="paper", help="default: paper")
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    parser.add_argument("--programs", type=Path, default=BUILT, metavar="DIR", help=f"default: {BUILT}")
    given = parser.parse_args()
    for program in ("stereogrid", "stereogrid-compare"):
        if not (given.programs / program).exists():
            sys.exit(f"{given.programs / program}: there is no such program. Build it: "
                     "cmake --build build/release --target stereogrid_tool stereogrid_compare")
    options = ["--preset", given.preset, *settings(given.settings)]
    frames = given.frames or (None if given.input else FRAMES)
    options += ["--frames", frames] if frames else []
    with tempfile.TemporaryDirectory() as work:
        try:
            drawn, left_out = figures.draw(**make_runs(given.input or SCENE, Path(work), given.programs, options))
            figures.save(drawn, given.out)
        except subprocess.CalledProcessError as error:  # the program has printed its message
            sys.exit(error.returncode)
        except figures.Complaint as complaint:
            sys.exit(f"make_figures.py: {complaint}")
    print("\n".join(left_out + [f"figures in {given.out}"]))


if __name__ == "__main__":
    main()
