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
import sys
import time
import warnings
from typing import Any

from . import _core, display
from ._core import (
    TERRAIN_CLASSES,
    WITNESSES,
    CameraResult,
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
    preset_advice,
    preset_for,
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
    "WITNESSES",
    "CameraResult",
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
    "preset_advice",
    "preset_for",
    "preset_names",
    "read_run",
    "run",
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


def _show_progress(done: int, total: int, begin_s: float) -> None:
    filled = 30 * done // total
    rate_hz = done / max(time.monotonic() - begin_s, 1e-3)
    bar = "#" * filled + "." * (30 - filled)
    print(f"\r[{bar}] {done}/{total} frames, {rate_hz:.1f} frames/s ", end="", file=sys.stderr, flush=True)


def run(
    drive: Recording | str | os.PathLike[str] | list[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    *,
    config: Config | str = "default",
    device: str | None = None,
    resume: bool = False,
    bar: bool | None = None,
    **options: Any,
) -> Run:
    """Processes a drive, writes the folder of a run and opens it, as `stereogrid run DRIVE --out OUT` does.

    drive: a Recording, or what open() takes, with its options. config: a preset's name, "auto", or a configuration.
    bar: progress on stderr; left out, if that is a terminal. Raises InputError, ConfigError, DeviceError.
    """
    if isinstance(drive, Recording) and options:
        raise TypeError(f"run(): {', '.join(options)} of a Recording. Give them to open().")
    recording = drive if isinstance(drive, Recording) else open(drive, **options)
    name = config if isinstance(config, str) else "default"
    if name == "auto":
        name = preset_for(recording)
    pipeline = Pipeline(preset(name) if isinstance(config, str) else config, recording.rigs, device=device)
    is_shown = sys.stderr.isatty() if bar is None else bar
    begin_s = time.monotonic()
    with RunWriter(out, recording, pipeline, preset=name, resume=resume) as writer:
        for done, frame in enumerate(writer, 1):
            writer.process(frame)
            if is_shown:
                _show_progress(done, len(recording), begin_s)
    if is_shown:
        print(file=sys.stderr)
    if advice := preset_advice(pipeline.config, pipeline.next_rig):
        warnings.warn(advice, RuntimeWarning, stacklevel=2)
    return read_run(out)
