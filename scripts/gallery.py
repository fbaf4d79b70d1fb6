#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the documentation site's gallery of runs; make() runs them and exports their pages."""
import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[1]
# name: title, what it shows, input, options
RUNS = {
    "crossing": ("A crossing", "A car and a pedestrian cross; the parked car is left behind.", "scene:crossing", []),
    "corridor": ("A robot's corridor", "Camera at 0.35 m, cells of 5 cm: a box, an oncoming walker, a ramp.",
                 "scene:corridor?camera=robot&frames=60", ["--preset", "robot"]),
    "ditch": ("A ditch", "Its edge is marked, what lies behind it is no ground (layers Elevation and Witness).",
              "scene:terrain?kind=ditch&camera=robot&frames=40", ["--preset", "robot"]),
}


def page() -> str:
    lines = ["# Gallery of runs", "",
             "Runs in the viewer's page, which `stereogrid export RUN --web DIR` writes ([files](format.md#a-web-page)). Nothing runs on a",
             "server; the scenes are built in.", ""]
    for name, (title, about, scene, options) in RUNS.items():
        lines += [f"## {title}", "", f'<p><a href="{name}/index.html">Open the run</a></p>', "", about, "", "```sh",
                  f"stereogrid run '{scene}'{''.join(' ' + word for word in options)} --out runs/{name} --mcap",
                  f"stereogrid export runs/{name} --web web/{name}", "```", ""]
    lines += ["## Your own pair", "", '<p><a href="playground/index.html">Open the playground</a></p>', "",
              "Two images and a calibration; the page computes the grid and uploads nothing ([the playground](live.md#the-playground)).", ""]
    return "\n".join(lines)


def tool() -> "str | None":
    """The program: $STEREOGRID, that of a build, or one on the PATH."""
    built = ROOT / "build" / "release" / "bin" / "stereogrid"
    return os.environ.get("STEREOGRID") or (str(built) if built.is_file() else shutil.which("stereogrid"))


def make(program: str, folder: Path) -> None:
    with TemporaryDirectory() as work:
        for name, (_, _, scene, options) in RUNS.items():
            run = f"{work}/{name}"
            subprocess.run([program, "run", scene, *options, "--out", run, "--mcap", "--quiet"], check=True)
            subprocess.run([program, "export", run, "--web", folder / name, "--quiet"], check=True)


if __name__ == "__main__":
    print(page(), end="")
