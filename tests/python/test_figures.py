# SPDX-License-Identifier: Apache-2.0
"""stereogrid.plot, stereogrid.rerun and python -m stereogrid."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import write_run

import stereogrid as sg


def run_module(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "stereogrid", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "MPLBACKEND": "Agg"})


def test_elevation_and_overlay(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    from stereogrid import plot

    pipeline = sg.Pipeline(sg.preset("default"), scene.rig)
    for frame in frames:
        result = pipeline.process(frame)
    assert plot.elevation(result).get_ylabel() == "x, ahead (m)"
    assert plot.grid(result).get_xlim()[0] > plot.grid(result).get_xlim()[1]  # y points to the left
    assert plot.overlay(frames[-1], result).get_images()
    with pytest.raises(ValueError, match=r"ground\.model"):
        plot.elevation(sg.Pipeline(sg.preset("paper"), scene.rig).process(frames[0]))


def test_colors_are_those_of_the_viewer() -> None:
    pytest.importorskip("matplotlib")
    from stereogrid import plot

    theme = (Path(__file__).parents[2] / "viewer" / "theme.css").read_text(encoding="utf-8")
    light = theme.split("@media")[0]
    for name, color in plot.COLORS.items():
        assert f"--{name}: {color};" in light
    assert plot.DIRECTIONS(0.5)[:3] == pytest.approx(plot.to_rgb(plot.COLORS["heading-4"]), abs=0.02)


def test_views_have_the_numbers_of_confirmed_obstacles(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    from stereogrid import plot

    pipeline = sg.Pipeline(sg.preset("default"), scene.rig)
    for frame in frames:
        result = pipeline.process(frame)
    axes = plot.grid(result)
    numbers = {str(obstacle.id) for obstacle in result.obstacles if obstacle.confirmed}
    assert {text.get_text().split(":")[0] for text in axes.texts if text.get_text()} == numbers
    in_image = {text.get_text().split(":")[0] for text in plot.overlay(frames[-1], result).texts}
    assert in_image <= numbers and len(in_image) > 0
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["object", "boundary", "drop", "motion in 1 s"]


def test_overlay_projects_as_the_library_does(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pytest.importorskip("matplotlib")
    import numpy as np

    from stereogrid import plot

    # a point of the road that the camera of height h sees at row v lies at x = f h / (v - cv)
    rig = scene.rig
    u, v = plot._in_image(rig, np.array([5.0]), np.array([1.0]), np.array([0.0]))
    assert v[0] == pytest.approx(rig.cy_px + rig.focal_px * rig.camera_height_m / 5)
    assert u[0] == pytest.approx(rig.cx_px - rig.focal_px / 5)


def test_tracks_of_a_run(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    from stereogrid import plot

    recording = sg.simulate("crossing", frames=12, width_px=256, height_px=160)
    axes = plot.tracks(sg.read_run(write_run(tmp_path / "run", recording)), frames_min=4)
    assert len(axes.lines) > 1 and axes.get_xlabel() == "x (m)"


def test_rerun(scene: sg.Recording, frames: list[sg.Frame], tmp_path: Path) -> None:
    rr = pytest.importorskip("rerun")
    import stereogrid.rerun

    rr.init("stereogrid_test", spawn=False)
    rr.save(tmp_path / "drive.rrd")
    pipeline = sg.Pipeline(sg.preset("default"), scene.rig)
    for frame in frames:
        stereogrid.rerun.log(frame, pipeline.process(frame))
    rr.disconnect()
    assert (tmp_path / "drive.rrd").stat().st_size > 100_000


def test_module_prints_and_draws(tmp_path: Path) -> None:
    done = run_module("scene:street?frames=2&width=256&height=160", "--no-plot", "--set", "grid.length_m=10")
    assert done.returncode == 0 and len(done.stdout.splitlines()) == 2, done.stderr
    pytest.importorskip("matplotlib")
    done = run_module("scene:street?frames=1&width=256&height=160", "--save", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "000000.png").stat().st_size > 10_000


def test_module_reports_errors() -> None:
    done = run_module("nowhere")
    assert done.returncode == 1 and "nowhere" in done.stderr and "Traceback" not in done.stderr
