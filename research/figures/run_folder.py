# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Reads a folder of `stereogrid run --save-stages` (docs/format.md), with its images and truth."""
import json
from pathlib import Path

import matplotlib.image
import numpy as np

LEVEL_BELOW_RAD = np.radians(1)
LEFT_FOLDERS = ("left", "image_0", "image_2", "image_00/data", "image_02/data")


class Complaint(Exception):
    """Fault and its remedy."""


class Run:
    def __init__(self, folder):
        self.folder = Path(folder)
        if not (self.folder / "run.json").is_file():
            raise Complaint(f"{folder}: has no run.json. Give a folder that `stereogrid run --out` has left.")
        about = json.loads((self.folder / "run.json").read_text())
        self.rig, self.grid, self.config, self.input = (about[key] for key in ("rig", "grid", "config", "input"))
        self.level_rig = about.get("level_rig", self.rig)
        self.disparities = self.config["matching"]["disparities"]
        self.lines = [json.loads(line) for line in (self.folder / "frames.jsonl").read_text().splitlines()]
        self.names = [line["name"] for line in self.lines]

    def place(self, name):
        """Index of a frame in the run; no name: the last."""
        if name is None:
            return len(self.names) - 1
        if name not in self.names:
            raise Complaint(f"{self.folder}: has no frame {name}. It has {len(self.names)}, {self.names[0]} to "
                            f"{self.names[-1]}.")
        return self.names.index(name)

    def arrays(self, kind, name):
        """`kind`: grids or stages."""
        file = self.folder / kind / f"{name}.npz"
        if not file.is_file():
            raise Complaint(f"{file}: is not there. Run again with --save-stages.")
        return np.load(file)

    @property
    def source(self):
        """Name of the input, without parent folders."""
        return Path(self.input["paths"][0]).name

    def left_image(self, name):
        """Grey, in [0, 1], turned level as the stages saw it."""
        root = Path(self.input["paths"][0])
        found = [root] if root.is_file() else [
            file for folder in LEFT_FOLDERS for file in sorted((root / folder).glob(f"{name}.*"))]
        if not found:
            raise Complaint(f"{root}: has no left image of frame {name}. Drives on disk have; `stereogrid simulate` "
                            "writes one from a scene.")
        image = matplotlib.image.imread(found[0])
        if image.dtype.kind in "ui":
            image = image / (255 if image.max() < 256 else 65535)
        grey = image if image.ndim == 2 else image[..., :3] @ (0.299, 0.587, 0.114)
        return level(grey, self.rig, self.level_rig)

    def truth(self, name):
        """True state of the cells of a rendered drive (truth/cells); None: no truth."""
        folder = Path(self.input["paths"][0]) / "truth"
        if not (folder / "cells" / f"{name}.npz").is_file():
            return None
        truth_grid = json.loads((folder / "grid.json").read_text())
        cells = np.load(folder / "cells" / f"{name}.npz")
        return cells if all(truth_grid[key] == value for key, value in self.grid.items()) else None


def level(image, rig, level_rig):
    """Levels the image of a camera pitched by more than 1°: rotation about the baseline."""
    pitch = rig["camera_pitch_rad"]
    if abs(pitch) <= LEVEL_BELOW_RAD:
        return image
    v, u = np.mgrid[0:level_rig["height_px"], 0:level_rig["width_px"]]
    right = (u - level_rig["cx_px"]) / level_rig["focal_px"]
    down = (v - level_rig["cy_px"]) / level_rig["focal_px"]
    ahead = np.sin(pitch) * down + np.cos(pitch)
    column = np.rint(rig["cx_px"] + rig["focal_px"] * right / ahead).astype(int)
    row = np.rint(rig["cy_px"] + rig["focal_px"] * (np.cos(pitch) * down - np.sin(pitch)) / ahead).astype(int)
    inside = (ahead > 0) & (column >= 0) & (column < image.shape[1]) & (row >= 0) & (row < image.shape[0])
    return np.where(inside, image[np.where(inside, row, 0), np.where(inside, column, 0)], 0)


def in_vehicle(points, rig, ground):
    """Lidar returns, given in the left camera's frame, in the vehicle's: x ahead, y to the left, height above the road.
    `ground` as a frame's line has it: of the camera turned level."""
    right, down, ahead = np.asarray(points, float).T
    turned = rig["camera_pitch_rad"] if abs(rig["camera_pitch_rad"]) > LEVEL_BELOW_RAD else 0
    down, ahead = np.cos(turned) * down + np.sin(turned) * ahead, np.cos(turned) * ahead - np.sin(turned) * down
    pitch, roll = ground["pitch_rad"], ground["roll_rad"]
    # distance below the camera along the road's normal
    below = np.cos(pitch) * (np.cos(roll) * down + np.sin(roll) * right) + np.sin(pitch) * ahead
    return np.stack([ahead, -right, ground["height_m"] - below], 1)
