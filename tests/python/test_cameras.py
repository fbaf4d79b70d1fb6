# SPDX-License-Identifier: Apache-2.0
"""Several cameras in one pipeline."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg


@pytest.fixture(scope="module")
def around() -> sg.Recording:
    return sg.simulate("around?cameras=3&turn_deg=120&focal=128", frames=4, width_px=256, height_px=160)


def config_around() -> sg.Config:
    config = sg.preset("default")
    config.grid.length_m = config.grid.rear_m = 10
    return config


def pipeline_of(rigs: sg.Rig | list[sg.Rig], device: str = "cpu") -> sg.Pipeline:
    return sg.Pipeline(config_around(), rigs, device=device)


def copy_of(frame: sg.Frame) -> sg.Frame:
    return sg.Frame(frame.left, frame.right, frame.stamp_ns, frame.pose, index=frame.index, camera=frame.camera)


def test_a_scene_with_three_cameras(around: sg.Recording) -> None:
    assert len(around.rigs) == 3 and repr(around.rigs[0]) == repr(around.rig)
    assert around.rigs[1].camera_yaw_rad == pytest.approx(2 * np.pi / 3)
    pipeline = pipeline_of(around.rigs)
    assert [rig.camera_x_m for rig in pipeline.rigs] == [rig.camera_x_m for rig in around.rigs]
    for frame in around:
        assert [other.camera for other in frame.others] == [1, 2]
        result = pipeline.process(frame)
    assert len(result.cameras) == 3 and not result.warnings
    seen = np.stack([camera.observed for camera in result.cameras]) != 0.5
    assert all(camera.has_images and camera.ground.estimated for camera in result.cameras)
    assert all(part.mean() > 0.1 for part in seen)
    observed = result.observed != 0.5
    assert not np.any(observed & ~seen.any(axis=0)) and all(observed.mean() > part.mean() for part in seen)
    assert result.cameras[1].stages.obstacle_disparity.shape == (160, 256)
    assert result.cameras[2].terrain is not None and result.cameras[2].elevation_m is not None
    assert result.cameras[1].rig.camera_yaw_rad == around.rigs[1].camera_yaw_rad


def test_a_list_of_frames_equals_a_frame_with_others(around: sg.Recording) -> None:
    whole, lists = pipeline_of(around.rigs), pipeline_of(around.rigs)
    for frame in around:
        parts = [copy_of(one) for one in (frame, *frame.others)]
        result = lists.process(parts)
        np.testing.assert_array_equal(result.occupancy, whole.process(frame).occupancy)
        assert result.name == frame.name
    missing = lists.process([sg.Frame(parts[1].left, parts[1].right, 400_000_000, camera=1)])
    assert [camera.has_images for camera in missing.cameras] == [False, True, False]
    assert np.all(missing.cameras[0].observed == 0.5) and missing.cameras[0].status == []


def test_frames_in_memory_and_pickles(around: sg.Recording) -> None:
    frames = []
    for frame in around:
        made = copy_of(frame)
        made.others = [copy_of(other) for other in frame.others]
        frames.append(pickle.loads(pickle.dumps(made)))
    recording = sg.Recording(frames, around.rigs)
    expected, pipeline = pipeline_of(around.rigs), pipeline_of(recording.rigs)
    for frame, same in zip(around, recording):
        result = pipeline.process(same)
        np.testing.assert_array_equal(result.occupancy, expected.process(frame).occupancy)
    copy = pickle.loads(pickle.dumps(result))
    assert copy.cameras[1].has_images
    np.testing.assert_array_equal(copy.cameras[2].observed, result.cameras[2].observed)


def test_a_camera_keeps_its_result() -> None:
    scene = sg.simulate("around?cameras=2&turn_deg=180&focal=128", frames=1, width_px=256, height_px=160)
    pipeline = pipeline_of(scene.rigs)
    observed = pipeline.process(scene[0]).cameras[1].observed
    before = observed.copy()
    pipeline.reset()
    pipeline.process(scene[0].others)
    np.testing.assert_array_equal(observed, before)
    assert not observed.flags.writeable


def test_mistakes(around: sg.Recording) -> None:
    frame = around[0]
    pipeline = pipeline_of(around.rigs)
    with pytest.raises(sg.ConfigError, match="no rigs"):
        pipeline_of([])
    with pytest.raises(sg.InputError, match="no frames"):
        pipeline.process([])
    with pytest.raises(TypeError, match="None in the list"):
        pipeline.process([frame, None])  # type: ignore[list-item]
    with pytest.raises(sg.InputError, match="second one of its camera"):
        pipeline.process([copy_of(frame), copy_of(frame)])
    with pytest.raises(sg.InputError, match=r"camera is 7 \(allowed 0 … 2\)"):
        pipeline.process([sg.Frame(frame.left, frame.right, camera=7)])


def test_masks_and_names(around: sg.Recording) -> None:
    rigs: Any = around.rigs
    mask = np.full((160, 256), 255, np.uint8)
    mask[80:] = 0
    rigs[1].mask = mask
    for rig, name in zip(rigs, ["front", "left", "right"]):
        rig.name = name
    assert "name='left'" in repr(pickle.loads(pickle.dumps(rigs[1])))
    frame = around[0]
    masked, whole = pipeline_of(rigs).process(frame), pipeline_of(around.rigs).process(frame)
    assert [camera.name for camera in masked.cameras] == ["front", "left", "right"]
    assert [camera.name for camera in whole.cameras] == ["camera0", "camera1", "camera2"]
    assert not masked.cameras[1].stages.road_disparity[80:].any() and whole.cameras[1].stages.road_disparity[80:].any()
    np.testing.assert_array_equal(masked.cameras[2].observed, whole.cameras[2].observed)
    assert min(camera.speed_limit_mps for camera in whole.cameras) == whole.speed_limit_mps
    again = sg.Recording([frame], rigs)
    np.testing.assert_array_equal(again.rigs[1].mask, mask)
    rigs[2].name = "left"
    with pytest.raises(sg.ConfigError, match="names of the cameras"):
        pipeline_of(rigs)
    rigs[2].mask = mask[:, :8]
    with pytest.raises(sg.ConfigError, match="mask of camera 2"):
        pipeline_of(rigs)


def test_folders_and_runs(around: sg.Recording, tmp_path: Path) -> None:
    around.save(tmp_path / "drive")
    assert (tmp_path / "drive/camera2/calibration.yaml").exists()
    drive = sg.open(tmp_path / "drive")
    two = sg.open(tmp_path / "drive", cameras=["camera2", "camera0"])
    assert [repr(rig) for rig in two.rigs] == [repr(drive.rigs[2]), repr(drive.rigs[0])]
    with pytest.raises(sg.ConfigError, match="camera2 twice"):
        sg.open(tmp_path / "drive", cameras=["camera2", "camera2/"])
    for rig, original in zip(drive.rigs, around.rigs):
        assert rig.camera_yaw_rad == pytest.approx(original.camera_yaw_rad)
    run = sg.run(drive, tmp_path / "run", config=config_around())
    expected, results = pipeline_of(drive.rigs), []
    for frame in drive:
        assert len(frame.others) == 2
        results.append(expected.process(frame))
    for result in results:
        np.testing.assert_array_equal(run.grids(result.name).occupancy, result.occupancy)


def test_notes_and_errors_name_their_camera(around: sg.Recording, tmp_path: Path) -> None:
    around.save(tmp_path / "drive")
    notes = sg.open(tmp_path / "drive").notes
    for camera in ("camera1: ", "camera2: "):
        assert any(note.startswith(camera + "calibration: ") for note in notes)
    assert sum(note.startswith("calibration: ") for note in notes) == 1
    with pytest.raises(sg.ConfigError, match="cameras: an entry is empty"):
        sg.open(tmp_path / "drive", cameras=["camera0", ""])
    poses = tmp_path / "poses.csv"
    poses.write_text("stamp_ns,x_m,y_m,yaw_rad\n" + "".join(f"{i * 100_000_000},0,0,0\n" for i in range(4)))
    other = tmp_path / "drive/camera1/poses.csv"
    head, *lines = [line.split(",") for line in other.read_text().splitlines()]
    late = [[name, str(int(stamp_ns) + 60_000_000_000), *pose] for name, stamp_ns, *pose in lines]
    other.write_text("".join(",".join(line) + "\n" for line in [head, *late]))
    with pytest.raises(sg.InputError, match=r"camera1.*there is no pose for the image of 60\.000 s"):
        sg.open(tmp_path / "drive", poses=poses)
