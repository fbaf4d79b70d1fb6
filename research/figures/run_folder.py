# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Reads a folder of `stereogrid run` (docs/format.md), with its images and truth."""
import json
from pathlib import Path

import matplotlib.image
import numpy as np

LEVEL_BELOW_RAD = np.radians(1)
LEFT_FOLDERS = ("left", "image_0", "image_2", "image_00/data", "image_02/data")


class Complaint(Exception):
    """Fault and its remedy."""


class Run:
    """A run; `name` and `ground` are those of its last frame."""

    def __init__(self, folder):
        self.folder = Path(folder)
        about = json.loads((self.folder / "run.json").read_text())
        self.rig, self.grid, self.config = (about[key] for key in ("rig", "grid", "config"))
        self.drive = Path(about["input"]["paths"][0])
        if abs(self.rig["camera_pitch_rad"]) > LEVEL_BELOW_RAD:
            raise Complaint(f"{self.drive}: the camera is pitched by more than 1°. Draw a drive with a level camera.")
        self.disparities = self.config["matching"]["disparities"]
        self.bins = {**self.config["u_disparity"], **self.config["paper"]}
        lines = [json.loads(line) for line in (self.folder / "frames.jsonl").read_text().splitlines()]
        self.grounds = {line["name"]: line["ground"] for line in lines}
        self.names = list(self.grounds)
        self.name, self.ground = lines[-1]["name"], lines[-1]["ground"]

    def stages(self, name=None):
        return np.load(self.folder / "stages" / f"{name or self.name}.npz")

    def grids(self, name=None):
        return np.load(self.folder / "grids" / f"{name or self.name}.npz")

    def left_image(self, name=None):
        """Grey, in [0, 1]."""
        name = name or self.name
        found = [self.drive] if self.drive.is_file() else [
            file for folder in LEFT_FOLDERS for file in sorted((self.drive / folder).glob(f"{name}.*"))]
        if not found:
            raise Complaint(f"{self.drive}: has no left image of frame {name} in {', '.join(LEFT_FOLDERS)}.")
        image = matplotlib.image.imread(found[0])
        if image.dtype.kind in "ui":
            image = image / (255 if image.max() < 256 else 65535)
        return image if image.ndim == 2 else image[..., :3] @ (0.299, 0.587, 0.114)

    def truth(self):
        """True state of the cells of a rendered drive (truth/cells); None: no truth of this grid."""
        folder = self.drive / "truth"
        cells = folder / "cells" / f"{self.name}.npz"
        if not cells.is_file() or not self.grid.items() <= json.loads((folder / "grid.json").read_text()).items():
            return None
        return np.load(cells)

    def in_vehicle(self, points):
        """Lidar returns of the left camera's frame in the vehicle's: x ahead, y to the left, height above the road."""
        right, down, ahead = np.asarray(points, float).T
        pitch, roll = self.ground["pitch_rad"], self.ground["roll_rad"]
        # distance below the camera along the road's normal
        below = np.cos(pitch) * (np.cos(roll) * down + np.sin(roll) * right) + np.sin(pitch) * ahead
        return np.stack([ahead, -right, self.ground["height_m"] - below], 1)
