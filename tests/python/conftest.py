# SPDX-License-Identifier: Apache-2.0
"""Drives and results that the tests share."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg

ROOT = Path(__file__).parents[2]
SCENE = "scene:street?frames=4&width=256&height=160"


@pytest.fixture(scope="session")
def scene() -> sg.Recording:
    return sg.simulate(SCENE)


@pytest.fixture(scope="session")
def frames(scene: sg.Recording) -> list[sg.Frame]:
    return list(scene)


def pipeline_of(recording: sg.Recording, **options: Any) -> sg.Pipeline:
    return sg.Pipeline(sg.preset("default"), recording.rig, device="cpu", **options)


def write_run(folder: Path, recording: sg.Recording, count: int = 100, **options: Any) -> Path:
    """Ends after `count` frames."""
    with sg.RunWriter(folder, recording, pipeline_of(recording), **options) as run:
        for number, frame in enumerate(run, 1):
            run.process(frame)
            if number == count:
                break
    return folder


def check_same_grids(run: Path, expected: Path) -> None:
    names = sorted(file.name for file in (expected / "grids").iterdir())
    assert names and sorted(file.name for file in (run / "grids").iterdir()) == names
    for name in names:
        assert (run / "grids" / name).read_bytes() == (expected / "grids" / name).read_bytes(), name


@pytest.fixture
def pipeline(scene: sg.Recording) -> sg.Pipeline:
    return pipeline_of(scene)


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain folder with truth."""
    folder = tmp_path_factory.mktemp("drives") / "drive"
    sg.simulate("street", frames=6, width_px=256, height_px=160).save(folder)
    return folder


def write_sweep(file: Path, frame: sg.Frame, rig: sg.Rig) -> None:
    """A lidar's points, made of the exact disparities; the lidar is where the camera is."""
    disparity = frame.truth.disparity
    assert disparity is not None
    v, u = np.nonzero(disparity[::2, ::2] > 1.5)
    v, u = 2 * v, 2 * u
    depth = rig.focal_px * rig.baseline_m / disparity[v, u]
    right = (u - rig.cx_px) * depth / rig.focal_px
    down = (v - rig.cy_px) * depth / rig.focal_px
    points = np.stack([depth, -right, -down, np.zeros_like(depth)], axis=1)
    points.astype(np.float32).tofile(file)


@pytest.fixture(scope="session")
def kitti(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive in KITTI's layout, with a lidar."""
    folder = tmp_path_factory.mktemp("kitti") / "05"
    scene = sg.simulate("street", frames=4, width_px=512, height_px=160)
    scene.save(folder / "plain")
    (folder / "velodyne").mkdir()
    for side, name in (("left", "image_0"), ("right", "image_1")):
        shutil.move(folder / "plain" / side, folder / name)
    for frame in scene:
        write_sweep(folder / "velodyne" / f"{frame.name}.bin", frame, scene.rig)
    shutil.rmtree(folder / "plain")
    rig = scene.rig
    f, cu, cv = rig.focal_px, rig.cx_px, rig.cy_px
    left = f"{f} 0 {cu} 0 0 {f} {cv} 0 0 0 1 0"
    right = f"{f} 0 {cu} {-f * rig.baseline_m} 0 {f} {cv} 0 0 0 1 0"
    lines = [f"P0: {left}", f"P1: {right}", f"P2: {left}", f"P3: {right}", "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0"]
    (folder / "calib.txt").write_text("\n".join(lines) + "\n")
    (folder / "times.txt").write_text("".join(f"{0.1 * i:e}\n" for i in range(4)))
    return folder


@pytest.fixture(scope="session")
def tool() -> Callable[..., str]:
    """Runs the command-line tool."""
    program = os.environ.get("STEREOGRID_TOOL", "")
    if not program:
        pytest.skip("the tool is not built (STEREOGRID_TOOL is not set)")

    def call(*arguments: Any) -> str:
        command = [program, "--quiet", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call
