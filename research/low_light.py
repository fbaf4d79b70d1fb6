#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores both matching methods by day and in low light, as a Markdown table. Low light: grey levels times GAIN, plus noise
of NOISE grey levels (standard deviation), in both images.

low_light.py TOOL INPUT...    inputs: folders with image_0/ and image_1/ of PNG files, and lidar
"""
import shutil
import sys
import tempfile
from pathlib import Path

import numpy
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
import score_runs  # noqa: E402

GAIN, NOISE = 0.12, 2.0
FIGURES = ("balanced_log_loss", "iou_occupied", "missed", "false_alarms", "known")


def darken(source: Path, folder: Path) -> Path:
    """A copy of a drive in low light; the noise is the same in every run."""
    random = numpy.random.default_rng(7)
    dark = folder / (source.name + ", low light")
    shutil.copytree(source, dark, copy_function=shutil.copyfile)
    for file in sorted([*dark.glob("image_0/*.png"), *dark.glob("image_1/*.png")]):
        grey = numpy.asarray(Image.open(file).convert("L"), dtype=float)
        noisy = grey * GAIN + random.normal(0, NOISE, grey.shape)
        Image.fromarray(numpy.clip(noisy.round(), 0, 255).astype(numpy.uint8)).save(file)
    return dark


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for source in map(Path, sys.argv[2:]):
            for drive in (source, darken(source, Path(folder))):
                for method in ("correlation", "semi_global"):
                    scores = score_runs.evaluated(sys.argv[1], str(drive), ["--set", f"matching.method={method}"])
                    figures = scores["series"]["occupancy"]["bands"]["3-20"]
                    rows.append([drive.name, method, *(score_runs.text_of(figures[key]["value"], 3) for key in FIGURES)])
    score_runs.print_table("filtered grids, 3–20 m", ["input", "method", *(score_runs.GRIDS[key] for key in FIGURES)], rows)


if __name__ == "__main__":
    main()
