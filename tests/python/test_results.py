# SPDX-License-Identifier: Apache-2.0
"""Shapes, types and lifetimes of what a frame leaves; texts, images and pickles of objects."""

from __future__ import annotations

import gc
import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import pipeline_of

import stereogrid as sg

PNG = b"\x89PNG\r\n"
VIEWS = ("occupancy", "observed", "age_s", "moving")


def test_shapes_and_types(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    result = pipeline.process(frames[0])
    shape = result.grid.shape
    assert shape == pipeline.grid.shape == (100, 100)
    for name in VIEWS:
        array = getattr(result, name)
        assert array.shape == shape and array.dtype == np.float32, name
    assert result.velocity.shape == (2, *shape)
    assert result.velocity_covariance.shape == (3, *shape)
    assert result.stages.obstacle_disparity.shape == frames[0].left.shape
    assert result.stages.visible.dtype == np.uint16
    assert result.stages.possible.ndim == 1
    assert set(result.timing_ms) >= {"match", "filter", "total"}
    assert result.pose == sg.Pose(0, 0, 0)
    assert result.rig.width_px == 256


def test_table_of_obstacles(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    results = [pipeline.process(frame) for frame in frames]
    result = max(results, key=lambda one: len(one.obstacles))
    assert len(result.obstacles) > 0
    table = result.obstacles_table()
    for name in ("id", "x_m", "vy_mps", "confirmed", "length_sigma_m"):
        assert table[name].tolist() == [getattr(obstacle, name) for obstacle in result.obstacles], name
    assert table["id"].dtype == np.int64 and table["confirmed"].dtype == np.bool_
    assert table["kind"] == [obstacle.kind for obstacle in result.obstacles]
    assert {len(column) for column in table.values()} == {len(result.obstacles)}
    assert "outline" not in table and "position_covariance" not in table


def test_terrain(frames: list[sg.Frame], scene: sg.Recording) -> None:
    flat = sg.Pipeline(sg.preset("paper"), scene.rig).process(frames[0])
    assert flat.elevation_m is None and flat.terrain is None and flat.witness is None
    assert flat.speed_limit_mps == float("inf") and flat.speed_limit_reason == "none"
    result = sg.Pipeline(sg.preset("default"), scene.rig).process(frames[0])
    assert result.elevation_m is not None and result.terrain is not None
    assert result.elevation_m.shape == result.terrain.shape == result.grid.shape
    assert result.terrain.max() < len(sg.TERRAIN_CLASSES)
    assert result.world_elevation_m is not None and result.world_terrain is not None and flat.world_terrain is None
    assert result.world_elevation_m.shape == result.world_terrain.shape == result.world.occupancy.shape
    assert result.witness is not None
    kinds = np.array(sg.WITNESSES)[result.witness & 15]
    assert set(kinds[result.terrain == sg.TERRAIN_CLASSES.index("drivable")]) == {"ground"}
    assert not np.isin(kinds[(result.observed < 0.5) | (result.occupancy < 0.5)], ["none", "passable"]).any()
    assert 0 < result.speed_limit_mps < 20 and result.speed_limit_reason in ("noise", "ditches", "drops", "descents")


def test_predictions(frames: list[sg.Frame], scene: sg.Recording) -> None:
    pipeline = sg.Pipeline(sg.preset("default"), scene.rig, device="cpu", horizons_s=[0.5, 1.0], stages=False)
    result = pipeline.process(frames[0])
    assert [prediction.horizon_s for prediction in result.predictions] == [0.5, 1.0]
    occupancy = result.predictions[1].occupancy
    kept = occupancy.copy()
    del result
    gc.collect()
    pipeline.process(frames[1])
    np.testing.assert_array_equal(occupancy, kept)


def test_arrays_are_read_only(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    result = pipeline.process(frames[0])
    for array in (*(getattr(result, name) for name in VIEWS), result.velocity, frames[0].left, result.stages.visible):
        assert not array.flags.writeable
        with pytest.raises(ValueError):
            array[0] = 1


def test_views_share_memory(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    result = pipeline.process(frames[0])
    for name in VIEWS:
        assert np.shares_memory(getattr(result, name), getattr(result, name)), name


@pytest.mark.parametrize("name", VIEWS)
def test_a_view_keeps_its_result_and_never_changes(name: str, scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pipeline = pipeline_of(scene)
    view = getattr(pipeline.process(frames[0]), name)
    world = pipeline.process(frames[1]).world
    layer = world.occupancy
    del world
    kept, kept_layer = view.copy(), layer.copy()
    for frame in frames[2:]:
        pipeline.process(frame)
    del pipeline
    gc.collect()
    np.testing.assert_array_equal(view, kept)
    np.testing.assert_array_equal(layer, kept_layer)


def test_obstacles(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pipeline = pipeline_of(scene)
    results = [pipeline.process(frame) for frame in frames]
    obstacles = results[-1].obstacles
    assert obstacles
    del results, pipeline
    gc.collect()
    outlines: list[Any] = [obstacle.outline for obstacle in obstacles]
    first = obstacles[0]
    assert first.kind in ("object", "boundary", "drop") and isinstance(first.moving, bool)
    assert first.position_covariance.shape == (2, 2)
    assert first.position_covariance[0, 1] == first.position_covariance[1, 0]
    del obstacles, first
    gc.collect()
    for outline in outlines:
        assert outline.ndim == 2 and outline.shape[1] == 2 and outline.dtype == np.float64
        assert np.isfinite(outline).all()


def test_occupancy_values(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    occupancy = np.array([[0, 0.5, 0.6], [0.34, 0.66, 1]], np.float32)
    assert sg.occupancy_values(occupancy).tolist() == [[0, -1, 60], [34, 66, 100]]
    assert sg.occupancy_values(occupancy, "trinary").tolist() == [[0, -1, -1], [0, 100, 100]]
    assert sg.occupancy_values(pipeline.process(frames[0]).world.occupancy).dtype == np.int8
    with pytest.raises(sg.ConfigError, match="scale 'ros' \\(allowed: percent, trinary, nav2, autoware\\)"):
        sg.occupancy_values(occupancy, "ros")


def test_state(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    first, second = pipeline_of(scene), pipeline_of(scene)
    first.process(frames[0])
    second.load_state(first.save_state())
    np.testing.assert_array_equal(first.process(frames[1]).occupancy, second.process(frames[1]).occupancy)
    with pytest.raises(sg.InputError):
        second.load_state(b"no state")


def test_grid() -> None:
    rig = sg.Rig(width_px=256, height_px=160, focal_px=205, cx_px=128, cy_px=80, baseline_m=0.22)
    grid = sg.Pipeline(sg.preset("default"), rig).grid
    assert grid.cell_at(*grid.center(3, 5)) == (3, 5)
    assert grid.cell_at(-100, 0) is None


def test_every_class_has_a_text(
    scene: sg.Recording, frames: list[sg.Frame], pipeline: sg.Pipeline, drive: Path, tmp_path: Path
) -> None:
    result = pipeline.process(frames[0])
    truth = frames[0].truth
    grid = sg.ObservedGrid(result.grid, result.occupancy)
    writer = sg.RunWriter(tmp_path / "run", sg.open(drive), sg.Pipeline(sg.preset("default"), sg.open(drive).rig))
    frame = next(iter(writer))
    writer.process(frame)
    writer.close()
    run = sg.read_run(tmp_path / "run")
    objects = [scene, iter(scene), *frames, pipeline, result, result.world, result.ground, result.stages, grid, truth]
    objects += [truth.ego, truth.objects[0], scene.truth_grid, run, run.frames[0], run.grids(frame.name), writer]
    objects += [scene.rig, result.grid, result.pose, sg.preset("default").grid, *result.obstacles]
    for one in objects:
        text = repr(one)
        assert text.startswith(f"{type(one).__name__}(") and text.endswith(")") and "object at" not in text, text
        assert len(text) < 1000, text
    assert "occupancy=<float32 100x100>" in repr(grid)
    assert repr(result.ground).startswith(f"Ground(height_m={result.ground.height_m}, ")
    assert "cell_size_m=0.2" in repr(sg.preset("default").grid)
    assert repr(scene) == "Recording(kind='built-in scene', frames=4, size_px=(256, 160), rate_hz=10)"


def test_notebooks_show_frames_and_results(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    pytest.importorskip("matplotlib")
    for one in [frames[0], pipeline.process(frames[0])]:
        shown: Any = one
        assert shown._repr_png_().startswith(PNG)
        page = shown._repr_html_()
        assert page.startswith("<table>") and "000000" in page and "data:image/png;base64," in page


def test_notebooks_without_matplotlib(
    pipeline: sg.Pipeline, frames: list[sg.Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    result: Any = pipeline.process(frames[0])
    assert result._repr_png_() is None
    assert "<img" not in result._repr_html_() and "100 x 100 cells of 0.2 m" in result._repr_html_()


def test_results_and_frames_are_pickled(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    config = sg.preset("default")
    pipeline = sg.Pipeline(config, scene.rig, device="cpu", horizons_s=[0.5])
    for frame in frames:
        result = pipeline.process(frame)
    copy = pickle.loads(pickle.dumps(result))
    for name in (*VIEWS, "velocity", "velocity_covariance", "elevation_m", "terrain", "world_elevation_m"):
        np.testing.assert_array_equal(getattr(copy, name), getattr(result, name), name)
    np.testing.assert_array_equal(copy.world.occupancy, result.world.occupancy)
    np.testing.assert_array_equal(copy.stages.visible, result.stages.visible)
    np.testing.assert_array_equal(copy.predictions[0].occupancy, result.predictions[0].occupancy)
    assert len(copy.obstacles) == len(result.obstacles) > 0
    np.testing.assert_array_equal(copy.obstacles[0].outline, result.obstacles[0].outline)
    for name in ("name", "index", "stamp_ns", "pose", "grid", "timing_ms", "status", "warnings"):
        assert getattr(copy, name) == getattr(result, name), name
    same = pickle.loads(pickle.dumps(frames[1]))
    np.testing.assert_array_equal(same.left, frames[1].left)
    np.testing.assert_array_equal(same.right, frames[1].right)
    assert (same.name, same.index, same.stamp_ns, same.pose) == ("000001", 1, 100_000_000, frames[1].pose)


def test_damaged_pickles(frames: list[sg.Frame]) -> None:
    frame: Any = frames[0]
    state = frame.__getstate__()
    with pytest.raises(sg.InputError, match="cut off"):
        sg.Frame.__new__(sg.Frame).__setstate__(state[:-10])  # type: ignore[attr-defined]
    with pytest.raises(sg.InputError, match=r"pickled by version 9.* \(allowed: "):
        sg.Frame.__new__(sg.Frame).__setstate__(state[:8] + b"9" + state[9:])  # type: ignore[attr-defined]


def test_dlpack(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    if np.lib.NumpyVersion(np.__version__) < "2.1.0":
        pytest.skip("this NumPy exports no read-only arrays by DLPack")
    result = pipeline.process(frames[0])
    for array in (result.occupancy, result.velocity, frames[0].left):
        shared = np.from_dlpack(array)
        np.testing.assert_array_equal(shared, array)
        assert np.shares_memory(shared, array)
