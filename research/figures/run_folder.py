# SPDX-License-Identifier: Apache-2.0
"""Reads a folder of `stereogrid run` (docs/format.md), with its images and truth."""
import json
from pathlib import Path

import numpy as np
import stereogrid

LEVEL_BELOW_RAD = np.radians(1)


class Fault(Exception):
    """A fault and its remedy."""


class Run:
    """A run; `name` and `ground` are those of its last frame."""

    def __init__(self, folder):
        self.folder = Path(folder)
        about = json.loads((self.folder / "run.json").read_text())
        run = stereogrid.read_run(folder)
        self.rig, self.grid, self.config = run.rig, run.grid, about["config"]
        self.drive = Path(about["input"]["paths"][0])
        if abs(self.rig.camera_pitch_rad) > LEVEL_BELOW_RAD:
            raise Fault(f"{self.drive}: the camera is pitched by more than 1°. Draw a drive with a level camera.")
        self.disparities = self.config["matching"]["disparities"]
        self.bins = {**self.config["u_disparity"], **self.config["paper"]}
        lines = [json.loads(line) for line in (self.folder / "frames.jsonl").read_text().splitlines()]
        self.grounds = {line["name"]: line["ground"] for line in lines}
        self.places = {frame.name: frame.index for frame in run.frames}
        self.names = list(self.places)
        self.name, self.ground = self.names[-1], lines[-1]["ground"]
        self.recording = stereogrid.open(str(self.drive))

    def stages(self, name=None):
        return np.load(self.folder / "stages" / f"{name or self.name}.npz")

    def grids(self, name=None):
        return np.load(self.folder / "grids" / f"{name or self.name}.npz")

    def left_image(self, name=None):
        """Grey, in [0, 1]."""
        return self.recording[self.places[name or self.name]].left / 255

    def truth(self):
        """True state of the cells of a scene or rendered drive; None: no truth of this grid."""
        if not self.recording.has_truth or self.recording.truth_grid.grid != self.grid:
            return None
        return self.recording[self.places[self.name]].truth

    def in_vehicle(self, points):
        """Lidar returns of the left camera's frame in the vehicle's: x ahead, y to the left, height above the road."""
        right, down, ahead = np.asarray(points, float).T
        pitch, roll = self.ground["pitch_rad"], self.ground["roll_rad"]
        # distance below the camera along the road's normal
        below = np.cos(pitch) * (np.cos(roll) * down + np.sin(roll) * right) + np.sin(pitch) * ahead
        return np.stack([ahead, -right, self.ground["height_m"] - below], 1)
