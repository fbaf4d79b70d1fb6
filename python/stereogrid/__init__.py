# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Stereo images in, probabilistic occupancy grids out.

    import stereogrid as sg
    recording = sg.open("drive")
    pipeline = sg.Pipeline(sg.preset("default"), recording.rig)
    for frame in recording:
        result = pipeline.process(frame)
        result.occupancy, result.velocity

The algorithms, defaults and checks are those of the C++ library (docs/python.md).
"""

from __future__ import annotations

import json
import os
from typing import Any

from . import _core, display
from ._core import (
    TERRAIN_CLASSES,
    Config,
    ConfigError,
    DeviceError,
    Error,
    Frame,
    FrameIterator,
    FrameResult,
    FrameStatus,
    FrameTruth,
    GridGeometry,
    GridLayers,
    Ground,
    InputError,
    ObservedGrid,
    Obstacle,
    Pipeline,
    Pose,
    Prediction,
    Recording,
    Rig,
    Run,
    RunFrame,
    RunGrids,
    RunWriter,
    SkippedFrameWarning,
    StageImages,
    TruthEgo,
    TruthGrid,
    TruthObject,
    occupancy_values,
    open,
    preset,
    preset_names,
    read_run,
    scene_names,
    simd_target,
    simulate,
)

display.install()

__version__ = _core.version()

__all__ = [
    "TERRAIN_CLASSES",
    "Config",
    "ConfigError",
    "DeviceError",
    "Error",
    "Frame",
    "FrameIterator",
    "FrameResult",
    "FrameStatus",
    "FrameTruth",
    "GridGeometry",
    "GridLayers",
    "Ground",
    "InputError",
    "ObservedGrid",
    "Obstacle",
    "Pipeline",
    "Pose",
    "Prediction",
    "Recording",
    "Rig",
    "Run",
    "RunFrame",
    "RunGrids",
    "RunWriter",
    "SkippedFrameWarning",
    "StageImages",
    "TruthEgo",
    "TruthGrid",
    "TruthObject",
    "evaluate",
    "occupancy_values",
    "open",
    "preset",
    "preset_names",
    "read_run",
    "scene_names",
    "simd_target",
    "simulate",
]


def evaluate(
    run: str | os.PathLike[str],
    input: str | os.PathLike[str] | None = None,
    *,
    truth: str = "",
    camera_height_m: float | None = None,
) -> dict[str, Any]:
    """Returns the figures that `stereogrid evaluate RUN --json` writes (docs/evaluation.md).

    input: left out, the one that the run was made from. truth: "lidar" or "truth"; left out, what the input has.
    Raises InputError.
    """
    figures: dict[str, Any] = json.loads(_core.evaluate_json(run, input, truth, camera_height_m))
    return figures
