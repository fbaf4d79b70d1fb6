# SPDX-License-Identifier: Apache-2.0
"""OBSTACLE_DISTANCE of `stereogrid run --mavlink`, as pymavlink receives it, beside the run's grids."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg

os.environ["MAVLINK20"] = "1"  # read by pymavlink when it is loaded
mavutil = pytest.importorskip("pymavlink.mavutil")

FRAMES = 12
SECTOR = np.radians(5)
UNKNOWN = 65535


@pytest.fixture(scope="module", params=["crossing", "empty"])
def drive(
    request: pytest.FixtureRequest, tool: Callable[..., str], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[Any]]:
    """A run and the packets sent with it."""
    folder = tmp_path_factory.mktemp("mavlink") / request.param
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{port}", dialect="common")
    scene = f"scene:{request.param}?frames={FRAMES}&width=256&height=160"
    tool("run", scene, "--out", folder, "--mavlink", f"127.0.0.1:{port}")
    packets = []
    while (packet := link.recv_match(blocking=True, timeout=1)) is not None:
        packets.append(packet)
    link.close()
    return folder, packets


def nearest_in_sectors(occupied: np.ndarray, grid: Any) -> np.ndarray:
    """Distance of the nearest of many points in occupied cells, m, by sector."""
    rows, columns = np.nonzero(occupied)
    inside = np.linspace(0, 1, 17)
    x = grid.x_min_m + grid.cell_size_m * (columns[:, None, None] + inside[None, :, None])
    y = grid.y_min_m + grid.cell_size_m * (rows[:, None, None] + inside[None, None, :])
    x, y = np.broadcast_arrays(x, y)
    sectors = np.round(-np.arctan2(y, x) / SECTOR).astype(int) % 72
    nearest = np.full(72, np.inf)
    np.minimum.at(nearest, sectors.ravel(), np.hypot(x, y).ravel())
    return nearest


def test_every_frame_has_a_message(drive: tuple[Path, list[Any]]) -> None:
    folder, packets = drive
    assert {packet.get_type() for packet in packets} == {"HEARTBEAT", "OBSTACLE_DISTANCE"}
    beats = [packet for packet in packets if packet.get_type() == "HEARTBEAT"]
    assert len(beats) == 2, "one a second"
    assert (beats[0].type, beats[0].autopilot) == (18, 8)
    assert [packet.get_seq() for packet in packets] == list(range(len(packets)))
    messages = [packet for packet in packets if packet.get_type() == "OBSTACLE_DISTANCE"]
    assert [one.time_usec for one in messages] == [frame.stamp_ns // 1000 for frame in sg.read_run(folder).frames]
    for one in messages:
        assert (one.increment, one.increment_f, one.angle_offset, one.frame, one.sensor_type) == (5, 5, 0, 12, 4)
        assert (one.get_srcSystem(), one.get_srcComponent()) == (1, 196)
        assert 0 < one.min_distance < one.max_distance < UNKNOWN


def test_distances_are_those_of_the_grid(drive: tuple[Path, list[Any]]) -> None:
    folder, packets = drive
    run = sg.read_run(folder)
    messages = [packet for packet in packets if packet.get_type() == "OBSTACLE_DISTANCE"]
    hits = free = 0
    for frame, message in zip(run.frames, messages, strict=True):
        occupancy = np.load(folder / "grids" / f"{frame.name}.npz")["occupancy"]
        occupied = np.reshape(sg.occupancy_values(occupancy, scale="trinary"), occupancy.shape) == 100
        nearest = nearest_in_sectors(occupied, run.grid)
        for distance, expected in zip(np.array(message.distances), nearest, strict=True):
            if distance <= message.max_distance:
                assert expected - 1.5 * run.grid.cell_size_m <= distance / 100 <= expected + 0.01
                hits += 1
            else:
                assert 100 * expected > message.max_distance - 2
                assert distance in (message.max_distance + 1, UNKNOWN)
                free += distance == message.max_distance + 1
        assert message.distances[36] == UNKNOWN, "behind the vehicle"
    assert hits > FRAMES if folder.name == "crossing" else free > FRAMES


@pytest.mark.parametrize("address", ["localhost", ":14540", "127.0.0.1:x"])
def test_addresses_are_checked_first(address: str, tmp_path: Path) -> None:
    program = os.environ.get("STEREOGRID_TOOL") or pytest.skip("the tool is not built (STEREOGRID_TOOL is not set)")
    command = [program, "run", "scene:empty?frames=1", "--out", str(tmp_path / "never"), "--mavlink", address]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode in (64, 75)
    assert "HOST:PORT" in done.stderr
    assert not (tmp_path / "never").exists()
