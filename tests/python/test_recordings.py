# SPDX-License-Identifier: Apache-2.0
"""Recordings, scenes and their truth."""

from __future__ import annotations

import gc
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import stereogrid as sg


def test_frames_of_a_scene(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    assert len(scene) == len(frames) == 4
    assert scene.kind == "built-in scene" and scene.has_truth and scene.rate_hz == 10
    for i, frame in enumerate(frames):
        assert frame.index == i and frame.name == f"{i:06d}" and frame.stamp_ns == i * 100_000_000
        assert frame.left.shape == (160, 256) and frame.left.dtype == np.uint8
        assert frame.right is not None and frame.right.shape == frame.left.shape
        assert frame.disparity is None and frame.pose is not None
        np.testing.assert_array_equal(scene[i].left, frame.left)
    np.testing.assert_array_equal(scene[-1].left, frames[-1].left)
    with pytest.raises(IndexError):
        scene[4]


def test_truth(frames: list[sg.Frame], scene: sg.Recording) -> None:
    truth = frames[1].truth
    assert truth.disparity is not None and truth.disparity.shape == (160, 256)
    assert truth.state is not None and truth.state.shape == scene.truth_grid.grid.shape
    assert truth.terrain is None
    assert truth.objects and truth.objects[0].footprint.shape[1] == 2
    assert truth.ego.pose == frames[1].pose


def test_a_scene_is_saved_and_opened(drive: Path, tmp_path: Path) -> None:
    recording = sg.open(drive)
    scene = sg.simulate("street", frames=6, width_px=256, height_px=160)
    assert recording.kind == "plain folder" and len(recording) == 6 and recording.rig.extrinsics_given
    for saved, rendered in zip(recording, scene):
        np.testing.assert_array_equal(saved.left, rendered.left)
        assert saved.pose is not None
        np.testing.assert_array_equal(saved.truth.state, rendered.truth.state)
    recording.save(tmp_path / "copy", truth=False)
    copy = sg.open(str(tmp_path / "copy"))
    assert not copy.has_truth
    with pytest.raises(sg.InputError, match="no exact truth"):
        copy[0].truth  # noqa: B018
    with pytest.raises(sg.InputError):
        recording.save(tmp_path / "copy")


def test_options(drive: Path) -> None:
    assert [frame.name for frame in sg.open(drive, frames="2:3")] == ["000002", "000003"]
    assert len(sg.open(drive, frames="4:")) == 2
    assert sg.open(drive, frames="4:")[0].name == "000004"
    assert all(frame.pose is None for frame in sg.open(drive, poses="none"))
    with_disparities = sg.open(drive, disparities=drive / "truth/disparity")[0]
    assert with_disparities.right is None and with_disparities.disparity is not None
    left, right = drive / "left/000001.png", drive / "right/000001.png"
    pair = sg.open([left, right], calibration=drive / "calibration.yaml")
    assert len(pair) == 1
    with pytest.raises(sg.ConfigError):
        sg.open(drive, frames="9:")
    with pytest.raises(sg.InputError):
        sg.open([])
    with pytest.raises(sg.InputError, match="none"):
        sg.open("scene:none")


def test_an_iterator_outlives_its_recording(drive: Path) -> None:
    iterator = iter(sg.open(drive))
    gc.collect()
    first = next(iterator)
    left = first.left
    del first
    rest = list(iterator)
    assert len(rest) == 5 and left.shape == (160, 256)
    truth = rest[0].truth
    del rest, iterator
    gc.collect()
    assert truth.state is not None and truth.state.sum() > 0


def test_many_iterators_that_are_not_finished(drive: Path) -> None:
    recording = sg.open(drive)
    for _ in range(20):
        next(iter(recording))
    first, second = iter(recording), iter(recording)
    assert [a.index == b.index for a, b in zip(first, second)] == [True] * 6


def test_damaged_frames_are_skipped(drive: Path, tmp_path: Path) -> None:
    shutil.copytree(drive, tmp_path / "drive")
    (tmp_path / "drive/left/000002.png").write_bytes(b"no image")
    recording = sg.open(tmp_path / "drive")
    with pytest.warns(sg.SkippedFrameWarning, match="000002"):
        names = [frame.name for frame in recording]
    assert names == ["000000", "000001", "000003", "000004", "000005"]
    assert [(index, name) for index, name, _ in recording.skipped] == [(2, "000002")]
    with pytest.raises(sg.InputError):
        recording[2]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sg.SkippedFrameWarning):
            list(recording)


def test_swapped_images_are_rejected(drive: Path, tmp_path: Path) -> None:
    shutil.copytree(drive, tmp_path / "drive")
    (tmp_path / "drive/left").rename(tmp_path / "drive/other")
    (tmp_path / "drive/right").rename(tmp_path / "drive/left")
    (tmp_path / "drive/other").rename(tmp_path / "drive/right")
    with pytest.raises(sg.InputError, match="swapped"):
        list(sg.open(tmp_path / "drive"))


def test_a_rig_of_a_file(drive: Path) -> None:
    rig = sg.Rig.from_file(drive / "calibration.yaml")
    assert rig.focal_px == sg.open(drive).rig.focal_px and rig.extrinsics_given


def test_a_run_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(sg.InputError):
        sg.read_run(tmp_path)
    with pytest.raises(sg.InputError):
        sg.evaluate(tmp_path)
