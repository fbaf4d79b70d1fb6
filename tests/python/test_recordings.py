# SPDX-License-Identifier: Apache-2.0
"""Recordings, scenes and their truth; frames made of arrays, recordings of them, slices of recordings."""

from __future__ import annotations

import gc
import json
import shutil
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import check_same_grids, pipeline_of, write_run

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


def test_the_mask_of_a_raw_pair_is_rectified(tmp_path: Path) -> None:
    (tmp_path / "calibration.yaml").write_text(
        "image: {width_px: 640, height_px: 480}\n"
        "left: {focal_u_px: 500, focal_v_px: 502, cx_px: 322, cy_px: 236, distortion: [-0.2, 0.05, 0, 0, 0]}\n"
        "right: {focal_u_px: 507, focal_v_px: 505, cx_px: 315, cy_px: 241, distortion: [-0.18, 0.04, 0, 0]}\n"
        "right_from_left: {rotation: [0.01, -0.02, 0.015], translation_m: [-0.2998, 0.006, -0.009]}\n"
        "mask: mask.pgm\n"
    )
    mask = np.full((480, 640), 255, np.uint8)
    mask[400:] = 0
    (tmp_path / "mask.pgm").write_bytes(b"P5 640 480 255\n" + mask.tobytes())
    rectified = sg.Rig.from_file(tmp_path / "calibration.yaml").mask
    assert rectified is not None and set(np.unique(rectified)) == {0, 255}
    first_masked = np.argmax(rectified == 0, axis=0)
    assert first_masked.max() - first_masked.min() > 5, "the bonnet's straight line is curved without distortion"


def test_a_run_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(sg.InputError):
        sg.read_run(tmp_path)
    with pytest.raises(sg.InputError):
        sg.evaluate(tmp_path)


def copies(frames: list[sg.Frame]) -> list[sg.Frame]:
    return [sg.Frame(f.left, f.right, f.stamp_ns, f.pose) for f in frames]


def test_a_frame_of_arrays(scene: sg.Recording, frames: list[sg.Frame], pipeline: sg.Pipeline) -> None:
    original = frames[2]
    assert original.right is not None
    frame = sg.Frame(original.left, original.right, 5, (1.0, 2.0, 0.5), index=2)
    np.testing.assert_array_equal(frame.left, original.left)
    assert frame.right is not None and frame.disparity is None
    assert (frame.name, frame.index, frame.stamp_ns, frame.pose) == ("000002", 2, 5, sg.Pose(1, 2, 0.5))
    assert sg.Frame(original.left, original.right, index=3, name="x").stamp_ns == 300_000_000
    with pytest.raises(sg.InputError, match="no truth"):
        frame.truth  # noqa: B018
    other = pipeline_of(scene)
    for frame, made in zip(frames, copies(frames)):
        np.testing.assert_array_equal(pipeline.process(frame).occupancy, other.process(made).occupancy)


def test_a_frame_keeps_copies() -> None:
    left = np.zeros((160, 256), np.uint8)
    frame = sg.Frame(left, left)
    left[:] = 9
    assert frame.left.max() == 0 and not frame.left.flags.writeable
    color = sg.Frame(np.full((4, 6, 3), 7, np.uint8), np.full((4, 6), 7.0), color="rgb")
    assert color.left.shape == (4, 6) and color.left.max() == 7


def test_measured_depths(scene: sg.Recording) -> None:
    left = np.zeros((160, 256), np.uint8)
    depth_mm = np.full(left.shape, 4000, np.uint16)
    frame = sg.Frame(left, depth=depth_mm, rig=scene.rig)
    expected = scene.rig.focal_px * scene.rig.baseline_m / 4
    np.testing.assert_allclose(frame.disparity, expected, rtol=1e-6)
    metres = sg.Frame(left, depth=depth_mm / 1000, rig=scene.rig)
    np.testing.assert_array_equal(metres.disparity, frame.disparity)
    external = sg.Frame(left, disparity=np.full(left.shape, expected, np.float32))
    np.testing.assert_array_equal(external.disparity, frame.disparity)


def test_arguments_of_a_frame() -> None:
    left = np.zeros((160, 256), np.uint8)
    with pytest.raises(TypeError, match="give right, disparity or depth"):
        sg.Frame(left)
    with pytest.raises(TypeError, match="depth without rig"):
        sg.Frame(left, depth=np.ones(left.shape))
    with pytest.raises(TypeError, match="disparity: dtype uint16"):
        sg.Frame(left, disparity=np.ones(left.shape, np.uint16))
    with pytest.raises(ValueError, match="index: -1"):
        sg.Frame(left, left, index=-1)


def test_a_run_over_frames_in_memory(scene: sg.Recording, frames: list[sg.Frame], tmp_path: Path) -> None:
    recording = sg.Recording(copies(frames), scene.rig)
    assert len(recording) == 4 and recording.kind == "arrays" and not recording.has_truth
    assert [frame.name for frame in recording] == [frame.name for frame in frames]
    check_same_grids(write_run(tmp_path / "run", recording), write_run(tmp_path / "scene", scene))
    run = sg.read_run(tmp_path / "run")
    assert [frame.index for frame in run.frames] == [0, 1, 2, 3]
    facts = json.loads((tmp_path / "run/run.json").read_text())
    assert facts["input"]["kind"] == "arrays" and facts["frames"]["complete"] and facts["matcher"] == "own"
    recording.save(tmp_path / "drive")
    np.testing.assert_array_equal(sg.open(tmp_path / "drive")[3].left, frames[3].left)


def test_frames_of_arrays_in_the_run_of_a_recording(
    scene: sg.Recording, frames: list[sg.Frame], tmp_path: Path
) -> None:
    write_run(tmp_path / "scene", scene)
    with sg.RunWriter(tmp_path / "run", scene, pipeline_of(scene)) as run:
        for frame in frames:
            run.process(sg.Frame(frame.left, frame.right, frame.stamp_ns, frame.pose, index=frame.index))
    check_same_grids(tmp_path / "run", tmp_path / "scene")


def test_recordings_of_frames_with_disparities(scene: sg.Recording, frames: list[sg.Frame], tmp_path: Path) -> None:
    made = [sg.Frame(f.left, stamp_ns=f.stamp_ns, disparity=f.truth.disparity) for f in frames]
    recording = sg.Recording(made, scene.rig)
    assert all(frame.pose is None and frame.right is None for frame in recording)
    write_run(tmp_path / "run", recording)
    assert json.loads((tmp_path / "run/run.json").read_text())["matcher"] == "given"
    with pytest.raises(sg.InputError, match="arrays"):
        sg.evaluate(tmp_path / "run")


def test_odometry_of_frames_in_memory(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    found = list(sg.Recording(copies(frames), scene.rig, poses="odometry"))
    assert all(frame.pose is not None for frame in found)
    assert [frame.pose for frame in found] != [frame.pose for frame in frames]
    assert all(frame.pose is None for frame in sg.Recording(copies(frames), scene.rig, poses="none"))


def test_frames_that_make_no_recording(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    with pytest.raises(sg.InputError, match="no frames"):
        sg.Recording([], scene.rig)
    first = frames[0]
    with pytest.raises(sg.InputError, match="stamp 0 ns of frame 1 is not after 0 ns"):
        sg.Recording([sg.Frame(first.left, first.right)] * 2, scene.rig)
    with pytest.raises(sg.InputError, match="two frames have the name 'a'"):
        sg.Recording([sg.Frame(first.left, first.right, stamp, name="a") for stamp in (0, 1)], scene.rig)
    with pytest.raises(sg.ConfigError, match=r"poses 'gps' \(allowed: none, odometry"):
        sg.Recording(copies(frames), scene.rig, poses="gps")


@pytest.mark.parametrize("places", [slice(1, 3), slice(2, None), slice(-1, None), slice(None, -1), slice(None)])
def test_slices(places: slice, scene: sg.Recording, frames: list[sg.Frame]) -> None:
    part: Any = scene[places]
    expected = frames[places]
    assert isinstance(part, sg.Recording) and len(part) == len(expected)
    assert [frame.index for frame in part] == [frame.index for frame in expected]
    np.testing.assert_array_equal(part[-1].left, expected[-1].left)


def test_a_slice_of_a_slice_and_its_run(drive: Path, tmp_path: Path) -> None:
    part = sg.open(drive)[1:5][1:3]
    assert [frame.name for frame in part] == ["000002", "000003"]
    check_same_grids(write_run(tmp_path / "slice", part), write_run(tmp_path / "frames", sg.open(drive, frames="2:3")))
    with pytest.raises(ValueError, match="step 2"):
        part[::2]
    with pytest.raises(IndexError, match="no frames"):
        part[2:]
