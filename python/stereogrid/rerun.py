# SPDX-License-Identifier: Apache-2.0
"""Logs results to the Rerun viewer (pip install stereogrid[rerun]).

import rerun as rr
rr.init("drive", spawn=True)
for frame in recording:
    stereogrid.rerun.log(frame, pipeline.process(frame))
"""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr

from . import Frame, FrameResult


def _colors(occupancy: Any) -> Any:
    grey = np.clip(255 * (1 - occupancy), 0, 255).astype(np.uint8)
    return np.repeat(grey[:, :, None], 3, axis=2)


def _cells(result: FrameResult) -> tuple[Any, Any]:
    x = result.grid.x_min_m + (np.arange(result.grid.nx) + 0.5) * result.grid.cell_size_m
    y = result.grid.y_min_m + (np.arange(result.grid.ny) + 0.5) * result.grid.cell_size_m
    return np.meshgrid(x, y)


def _log_grid(result: FrameResult, path: str) -> None:
    x, y = _cells(result)
    known = np.abs(result.occupancy - 0.5) > 0.05
    z = np.zeros_like(x) if result.elevation_m is None else np.nan_to_num(result.elevation_m)
    points = np.stack([x[known], y[known], z[known]], axis=1)
    rr.log(
        f"{path}/grid", rr.Points3D(points, colors=_colors(result.occupancy)[known], radii=result.grid.cell_size_m / 2)
    )
    rr.log(f"{path}/grid_image", rr.Image(_colors(result.occupancy)[::-1, :, :]))


def _log_obstacles(result: FrameResult, path: str) -> None:
    lines = [np.column_stack([o.outline, np.zeros(len(o.outline))]) for o in result.obstacles if len(o.outline) > 1]
    rr.log(f"{path}/obstacles", rr.LineStrips3D(lines))
    moving = [o for o in result.obstacles if o.moving]
    rr.log(
        f"{path}/velocities",
        rr.Arrows3D(origins=[[o.x_m, o.y_m, 0] for o in moving], vectors=[[o.vx_mps, o.vy_mps, 0] for o in moving]),
    )


def log(frame: Frame, result: FrameResult, path: str = "vehicle") -> None:
    """Logs camera image, grid with elevation, obstacles and pose at the frame's instant."""
    rr.set_time("stamp", duration=frame.stamp_ns * 1e-9)
    pose = result.pose
    rr.log(
        path,
        rr.Transform3D(
            translation=[pose.x_m, pose.y_m, 0], rotation=rr.RotationAxisAngle([0, 0, 1], radians=pose.yaw_rad)
        ),
    )
    rr.log(f"{path}/left", rr.Image(frame.left))
    _log_grid(result, path)
    _log_obstacles(result, path)
