# SPDX-License-Identifier: Apache-2.0
"""Results equal those of `stereogrid run` byte for byte."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg

pytestmark = pytest.mark.tool


def check_equal(run: Path, folder: Path, recording: sg.Recording, config: sg.Config) -> None:
    pipeline = sg.Pipeline(config, recording.rig, device="cpu")
    lines = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    results = [pipeline.process(frame) for frame in recording]
    assert [result.name for result in results] == [line["name"] for line in lines]
    for result, line in zip(results, lines):
        file = folder / f"{result.name}.npz"
        result.save(file)
        assert file.read_bytes() == (run / "grids" / file.name).read_bytes(), result.name
        with np.load(run / "grids" / file.name) as arrays:
            check_arrays(result, arrays)
        assert [status.name for status in result.status] == line["status"]
        assert result.warnings == line["warnings"]
        expected = [(written["id"], written["outline_m"]) for written in line["obstacles"]]
        assert [(obstacle.id, obstacle.outline.tolist()) for obstacle in result.obstacles] == expected


def check_arrays(result: sg.FrameResult, arrays: Any) -> None:
    filtered = ["occupancy", "moving", "age_s", "velocity", "velocity_covariance"]
    terrain = ["elevation_m", "terrain", "world_elevation_m", "world_elevation_sigma_m", "world_terrain"]
    for name in ["observed", *filtered, *terrain]:
        if name in arrays:
            np.testing.assert_array_equal(getattr(result, name), arrays[name], strict=True)
        else:
            assert getattr(result, name) is None
    for name in filtered:
        np.testing.assert_array_equal(getattr(result.world, name), arrays["world_" + name], strict=True)
    assert [result.world.grid.x_min_m, result.world.grid.y_min_m] == arrays["world_origin"].tolist()


def test_of_a_scene(tool: Any, tmp_path: Path) -> None:
    scene = "scene:crossing?frames=8"
    tool("run", scene, "--out", tmp_path / "run", "--device", "cpu")
    check_equal(tmp_path / "run", tmp_path, sg.open(scene), sg.preset("default"))


def test_of_a_folder_with_odometry(tool: Any, drive: Path, tmp_path: Path) -> None:
    # neither poses nor extrinsics: both are estimated
    shutil.copytree(drive, tmp_path / "drive")
    (tmp_path / "drive/poses.csv").unlink()
    calibration = tmp_path / "drive/calibration.yaml"
    lines = calibration.read_text().splitlines()
    calibration.write_text("\n".join(line for line in lines if not line.startswith("mount")) + "\n")
    tool("run", tmp_path / "drive", "--out", tmp_path / "run", "--device", "cpu", "--frames", "1:4")
    recording = sg.open(tmp_path / "drive", frames="1:4")
    assert not recording.rig.extrinsics_given
    check_equal(tmp_path / "run", tmp_path, recording, sg.preset("default"))


def test_of_a_preset_with_settings(tool: Any, drive: Path, tmp_path: Path) -> None:
    tool("run", drive, "--out", tmp_path / "run", "--device", "cpu", "--preset", "robot", "--set", "grid.length_m=8")
    config = sg.preset("robot")
    config.grid.length_m = 8
    check_equal(tmp_path / "run", tmp_path, sg.open(drive), config)


def test_of_external_disparities(tool: Any, drive: Path, tmp_path: Path) -> None:
    disparities = drive / "truth/disparity"
    tool("run", drive, "--out", tmp_path / "run", "--device", "cpu", "--disparities", disparities)
    check_equal(tmp_path / "run", tmp_path, sg.open(drive, disparities=disparities), sg.preset("default"))


def test_of_scores(tool: Any, drive: Path, tmp_path: Path) -> None:
    tool("run", drive, "--out", tmp_path / "run", "--device", "cpu")
    tool("evaluate", tmp_path / "run", "--json", tmp_path / "scores.json")
    assert sg.evaluate(tmp_path / "run") == json.loads((tmp_path / "scores.json").read_text())


def test_of_a_run_that_is_read(tool: Any, drive: Path, tmp_path: Path) -> None:
    tool("run", drive, "--out", tmp_path / "run", "--device", "cpu")
    run = sg.read_run(tmp_path / "run")
    assert len(run) == len(run.frames) == 6
    frame = run.frames[2]
    grids = run.grids(frame.name)
    with np.load(tmp_path / "run/grids" / f"{frame.name}.npz") as arrays:
        for name in ("observed", "occupancy", "velocity"):
            np.testing.assert_array_equal(getattr(grids, name), arrays[name], strict=True)
    with pytest.raises(sg.InputError):
        run.grids("none")
