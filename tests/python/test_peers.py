# SPDX-License-Identifier: Apache-2.0
"""Recordings of the tool, decoded by other projects' packages, hold what read_run() gives."""

from __future__ import annotations

import cmath
import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg

pytestmark = pytest.mark.tool
FRAMES = 12
ONCE = {"/tf_static": 1, "/diagnostics": 2}  # latched; once a second
Topics = dict[str, list[Any]]


@pytest.fixture(scope="module")
def recorded(tool: Callable[..., str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run, with drive.mcap in it."""
    folder = tmp_path_factory.mktemp("peers") / "run"
    scene = f"scene:crossing?frames={FRAMES}&width=256&height=160"
    more = ["--predict", "0.5", "--save-stages", "--points-voxel", "0"]
    tool("run", scene, "--out", folder, "--mcap", folder / "drive.mcap", *more)
    return folder


@pytest.fixture(scope="module")
def topics(recorded: Path) -> Topics:
    """Messages of every topic, as the package mcap-ros2-support decodes them."""
    reader = pytest.importorskip("mcap.reader")
    decoder = pytest.importorskip("mcap_ros2.decoder")
    found: Topics = {}
    with (recorded / "drive.mcap").open("rb") as file:
        messages = reader.make_reader(file, decoder_factories=[decoder.DecoderFactory()])
        for _, channel, _, message in messages.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def plain(value: Any) -> Any:
    """A message of any package as JSON has it."""
    if isinstance(value, (bytes, bytearray, memoryview)):
        return bytes(value).hex()
    if isinstance(value, np.ndarray):
        return plain(value.tobytes() if value.dtype == np.uint8 else value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if not hasattr(value, "__slots__") and not dataclasses.is_dataclass(value):
        return value
    names = [field.name for field in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else value.__slots__
    return {name: plain(getattr(value, name)) for name in names if name != "__msgtype__"}


def below(topics: Topics, name: str) -> list[Any]:
    return topics["/stereo_grid/" + name]


def cells(grid: Any) -> Any:
    return np.array(grid.data, np.int8).reshape(grid.info.height, grid.info.width)


def arrays(folder: Path, kind: str, frame: sg.RunFrame) -> Any:
    return np.load(folder / kind / f"{frame.name}.npz")


def test_every_topic_has_every_frame(recorded: Path, topics: Topics) -> None:
    assert len(topics) == 20
    assert {topic: len(messages) for topic, messages in topics.items()} == {**dict.fromkeys(topics, FRAMES), **ONCE}
    for frame, scan in zip(sg.read_run(recorded).frames, below(topics, "scan")):
        assert scan.header.stamp.sec * 10**9 + scan.header.stamp.nanosec == frame.stamp_ns


def test_grids(recorded: Path, topics: Topics) -> None:
    run = sg.read_run(recorded)
    for i, frame in enumerate(run.frames):
        grids = run.grids(frame.name)
        world = arrays(recorded, "grids", frame)
        ahead = arrays(recorded, "predictions", frame)["world_occupancy"][0]
        observed = below(topics, "observed_grid")[i]
        assert observed.info.origin.position.y == pytest.approx(run.grid.y_min_m)
        for message, expected in (
            (observed, grids.observed),
            (below(topics, "occupancy_grid")[i], world["world_occupancy"]),
            (below(topics, "predicted_grid_0_5")[i], ahead),
        ):
            np.testing.assert_array_equal(cells(message), sg.occupancy_values(expected))
        layers = {"age": world["world_age_s"], "occupancy": world["world_occupancy"], "moving": world["world_moving"]}
        layers |= dict(zip(("velocity_x", "velocity_y"), world["world_velocity"]))
        grid_map = below(topics, "grid_map")[i]
        for name, expected in layers.items():
            data = grid_map.data[grid_map.layers.index(name)].data
            values = np.array(data, np.float32)[::-1].reshape(expected.shape)  # from the largest x and y
            np.testing.assert_array_equal(values, np.where(np.isfinite(layers["age"]), expected, np.nan))
        packed = below(topics, "packed_grid")[i]
        bytes_of = np.frombuffer(packed.data, np.uint8).reshape(-1, packed.column_count, packed.cell_stride)
        assert np.abs(bytes_of[:, :, 0] / 255 - world["world_occupancy"]).max() <= 0.002


def test_poses_and_obstacles(recorded: Path, topics: Topics) -> None:
    count = 0
    for i, frame in enumerate(sg.read_run(recorded).frames):
        pose = frame.pose
        transform = topics["/tf"][i].transforms[0].transform
        for at in (below(topics, "odometry")[i].pose.pose.position, transform.translation):
            assert (at.x, at.y) == pytest.approx((pose.x_m, pose.y_m))
        shown = [obstacle for obstacle in frame.obstacles if obstacle.confirmed]
        found, boxes = below(topics, "obstacles")[i].obstacles, below(topics, "detections")[i].detections
        assert len(found) == len(boxes) == len(shown)
        turn = cmath.exp(1j * pose.yaw_rad)
        for obstacle, sent, box in zip(shown, found, boxes):
            assert int.from_bytes(bytes(sent.uuid.uuid)[8:], "big") == obstacle.id
            place = complex(pose.x_m, pose.y_m) + turn * complex(obstacle.x_m, obstacle.y_m)
            assert complex(sent.position.x, sent.position.y) == pytest.approx(place)
            velocity = turn * complex(obstacle.vx_mps, obstacle.vy_mps)
            assert complex(sent.velocity.x, sent.velocity.y) == pytest.approx(velocity)
            assert box.results[0].hypothesis.class_id == obstacle.kind
        outlines = [one for one in below(topics, "obstacle_markers")[i].markers if one.ns in ("outlines", "drops")]
        assert len(outlines) == len(shown)
        count += len(shown)
    assert count > 0


def test_images_and_points(recorded: Path, topics: Topics) -> None:
    run = sg.read_run(recorded)
    size = run.rig.height_px, run.rig.width_px
    for i, frame in enumerate(run.frames):
        stages = arrays(recorded, "stages", frame)
        expected = np.maximum(stages["obstacle_disparity"], stages["road_disparity"])
        disparity = below(topics, "disparity")[i]
        values = np.frombuffer(disparity.image.data, np.float32).reshape(size)
        np.testing.assert_array_equal(np.maximum(values, 0), expected)
        assert (disparity.f, disparity.t) == pytest.approx((run.rig.focal_px, run.rig.baseline_m))
        points = below(topics, "points")[i]
        assert points.width * points.height == np.count_nonzero(expected)
        info = below(topics, "left/camera_info")[i]
        assert (info.height, info.width) == size and info.p[0] == run.rig.focal_px
        for name in ("left/image_annotated/compressed", "u_disparity/compressed"):
            assert bytes(below(topics, name)[i].data)[:2] == b"\xff\xd8"
        assert below(topics, "status")[i].status[0].values[0].value == str(i + 1)


def test_rosbags_decodes_the_same(recorded: Path, topics: Topics) -> None:
    highlevel = pytest.importorskip("rosbags.highlevel")
    found: Topics = {}
    with highlevel.AnyReader([recorded / "drive.mcap"]) as reader:
        for connection, _, data in reader.messages():
            found.setdefault(connection.topic, []).append(reader.deserialize(data, connection.msgtype))
    assert found.keys() == topics.keys()
    for topic, messages in topics.items():
        assert [json.dumps(plain(one)) for one in found[topic]] == [json.dumps(plain(one)) for one in messages], topic


def test_rerun_reads_every_topic(recorded: Path, topics: Topics) -> None:
    chunk = pytest.importorskip("rerun.chunk")
    times: dict[str, set[Any]] = {}
    grids: list[Any] = []
    for part in chunk.McapReader(recorded / "drive.mcap").stream():
        batch = part.to_record_batch()
        if "message_log_time" not in batch.schema.names:
            continue  # the channel
        times.setdefault(part.entity_path, set()).update(batch["message_log_time"].to_pylist())
        if part.entity_path == "/stereo_grid/observed_grid":
            grids += [np.array(data, np.uint8).view(np.int8) for data in batch["GridMap:data"].to_pylist()]
    counts = [{topic: len(found) for topic, found in source.items()} for source in (times, topics)]
    assert counts[0] == counts[1]
    assert len(grids) == FRAMES
    for grid, message in zip(grids, below(topics, "observed_grid")):
        np.testing.assert_array_equal(grid.reshape(cells(message).shape)[::-1], cells(message))
