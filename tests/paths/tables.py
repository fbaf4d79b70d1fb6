# SPDX-License-Identifier: Apache-2.0
"""The tables of the tests of paths: scenes, devices, presets, extrinsics, poses and bounds. A new one joins by a
row; sources are in sources.py."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


class Row(NamedTuple):
    """A run: one entry of each table."""

    scene: str
    source: str
    device: str
    preset: str
    extrinsics: str
    poses: str

    def __str__(self) -> str:
        return "/".join(self)


@dataclass(frozen=True)
class Scene:
    car: str
    """Argument of `stereogrid simulate` without size and number of frames."""
    robot: str = ""
    """The same for preset robot. "": the car's, which has no scores, as its truth has other cells."""
    size: "tuple[int, int]" = (512, 320)
    frames: int = 6
    first: int = 0
    """Frames before this one are left out."""
    is_level: bool = True
    """The nearest ground is the plane in view, so extrinsics can be estimated."""
    has_drop: bool = False
    moving_for: "tuple[str, ...]" = ()
    """Presets whose grid contains moving objects."""
    true_velocity_mps: float = 0.15
    """Largest median error of velocities with true disparities."""
    scored: "tuple[str, ...]" = ("default", "robot", "paper")


@dataclass(frozen=True)
class Device:
    short: bool = False
    """Takes the short form of a scene: few, small frames, as it needs seconds for each."""
    live_speed: float = 1
    """--speed at which no frame of a recording is dropped."""
    tolerances: "dict[str, float]" = field(default_factory=dict)
    """Largest differences of arrays of grids from the CPU's; others are equal to the bit."""


@dataclass(frozen=True)
class Preset:
    terrain: bool = True
    """Has the terrain stage."""
    flow: bool = True
    """Has scene flow."""
    log_loss: float = 0.02
    """Largest increase from the own path to own disparities as external ones."""
    log_loss_of_true: float = 0
    """The same for true disparities."""
    short: "tuple[str, ...]" = ()
    """Parameters of short runs."""


SCENES = {
    # the car comes at 16 m/s, in view for half a second
    "street": Scene("street?seed=1", frames=16, first=14, moving_for=("default",), true_velocity_mps=0.35,
                    scored=("default", "paper")),
    "edge": Scene("terrain?kind=ditch&depth=0.9&span=5",
                  "terrain?kind=ditch&depth=0.3&span=1.5&camera=robot&pitch_deg=0", is_level=False, has_drop=True),
    "stairs": Scene("terrain?kind=stairs&rise=-0.17", "terrain?kind=stairs&rise=-0.12&camera=robot&pitch_deg=0",
                    is_level=False, has_drop=True),
    "ramp": Scene("terrain?kind=ramp&at=1", "terrain?kind=ramp&at=0.8&camera=robot&pitch_deg=0",
                  is_level=False),
    "corridor": Scene("corridor?camera=robot&pitch_deg=0", "corridor?camera=robot&pitch_deg=0", size=(384, 240),
                      frames=8, scored=("robot",)),
    "crossing": Scene("crossing?seed=1", size=(384, 240), frames=16, moving_for=("default", "paper"),
                      scored=("default", "paper")),
}
BASELINE_M = 7 / 32
ROBOT_BASELINE_M = 3 / 32
"""Baselines that the CameraInfo of a bag keeps to the bit: their product with the focal length is exact."""
SHORT = Scene("", size=(192, 120), frames=3)
DEVICES = {
    "cpu": Device(),
    "reference": Device(short=True, live_speed=0.03),
    # the ground's fit adds in another order; its standard deviations are rounded to 2^-20 rad
    "cuda": Device(short=True, live_speed=0.03, tolerances={"elevation_sigma_m": 1e-6}),
}
SMALL = ("matching.window_px=11", "matching.disparities=32", "grid.length_m=8", "grid.width_m=8")
PRESETS = {
    "default": Preset(),
    "robot": Preset(),
    "paper": Preset(terrain=False, flow=False, log_loss=0.04, log_loss_of_true=0.06, short=SMALL),
}
EXTRINSICS = ("given", "estimated")
POSES = ("file", "odometry", "none")


@dataclass(frozen=True)
class Bounds:
    """Measured with the presets and scenes above; see CONTRIBUTING.md."""

    frames_with_drop: float = 0.5
    flips: float = 0.005
    edges: float = 0.05
    deadly: float = 0.01
    velocity_mps: float = 0.3
    true_statuses: int = 1
    true_edges: float = 0.99
    true_deadly: float = 0.002


BOUNDS = Bounds()
TURN_ROWS = 20
"""Rows of a turn beside the covering ones."""
GAPS: "tuple[str, ...]" = ()
"""Patterns of findings ("row: check") that are known not to hold."""
