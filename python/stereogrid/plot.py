# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of results with Matplotlib (pip install stereogrid[plot]).

Every function draws into `axes`, or into new ones, and returns them.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from . import Frame, FrameResult, GridGeometry, Obstacle, Rig

MOVING_MPS = 1.0
"""Cells and obstacles below this speed have no arrow."""
NEAR_M = 10.0
"""Static objects within this distance are drawn with their height."""


def _extent(grid: GridGeometry) -> tuple[float, float, float, float]:
    """x is drawn upwards and y to the left: left, right, bottom, top."""
    x_min, x_max, y_min, y_max = grid.extent
    return y_min, y_max, x_min, x_max


def _draw_map(axes: Any, grid: GridGeometry, values: Any, **style: Any) -> Any:
    image = axes.imshow(np.asarray(values).T, origin="lower", extent=_extent(grid), interpolation="nearest", **style)
    axes.set_xlim(*reversed(_extent(grid)[:2]))
    axes.set_xlabel("y (m)")
    axes.set_ylabel("x (m)")
    axes.set_aspect("equal")
    return image


def _arrows(axes: Any, result: FrameResult, every: int) -> None:
    vx, vy = result.velocity
    shown = (result.occupancy > 0.5) & (np.hypot(vx, vy) > MOVING_MPS)
    shown[np.arange(shown.shape[0]) % every != 0, :] = False
    shown[:, np.arange(shown.shape[1]) % every != 0] = False
    iy, ix = np.nonzero(shown)
    x = result.grid.x_min_m + (ix + 0.5) * result.grid.cell_size_m
    y = result.grid.y_min_m + (iy + 0.5) * result.grid.cell_size_m
    axes.quiver(y, x, vy[iy, ix], vx[iy, ix], color="tab:blue", angles="xy", scale_units="xy", scale=4, width=0.004)


def _closed(points: Any, obstacle: Obstacle) -> Any:
    return np.vstack([points, points[:1]]) if obstacle.kind == "object" else points


def _outline(axes: Any, obstacle: Obstacle) -> None:
    points = _closed(obstacle.outline, obstacle)
    color = "tab:red" if obstacle.moving else "tab:orange"
    axes.plot(points[:, 1], points[:, 0], color=color, linewidth=1.5)
    if obstacle.moving:
        tip = (obstacle.y_m + obstacle.vy_mps, obstacle.x_m + obstacle.vx_mps)
        axes.annotate("", tip, (obstacle.y_m, obstacle.x_m), arrowprops={"arrowstyle": "->", "color": color})


def grid(result: FrameResult, axes: Any = None, *, observed: bool = False, every: int = 2) -> Any:
    """Draws the occupancy from above (black: occupied), arrows of moving cells, and outlines of obstacles.

    every: distance of the arrows in cells.
    """
    axes = axes or plt.subplots()[1]
    _draw_map(axes, result.grid, result.observed if observed else result.occupancy, cmap="gray_r", vmin=0, vmax=1)
    if not observed:
        _arrows(axes, result, every)
    for obstacle in result.obstacles:
        _outline(axes, obstacle)
    axes.set_ylim(*_extent(result.grid)[2:])  # obstacles reach beyond the grid
    axes.set_title(result.name)
    return axes


def elevation(result: FrameResult, axes: Any = None) -> Any:
    """Draws the elevation of the ground, m. Raises ValueError: the pipeline's ground.model is plane."""
    if result.elevation_m is None:
        raise ValueError("elevation: none in the result. Set ground.model to terrain.")
    axes = axes or plt.subplots()[1]
    image = _draw_map(axes, result.grid, result.elevation_m, cmap="terrain")
    axes.figure.colorbar(image, ax=axes, label="elevation (m)")
    axes.set_title(result.name)
    return axes


def _in_image(rig: Rig, x_m: Any, y_m: Any, z_m: Any) -> tuple[Any, Any]:
    """Pixels of points of the vehicle frame, as the rig's camera sees them."""
    cos, sin = np.cos(rig.camera_pitch_rad), np.sin(rig.camera_pitch_rad)
    up = z_m - rig.camera_height_m
    right, down, ahead = -y_m, -(sin * x_m + cos * up), cos * x_m - sin * up
    cos, sin = np.cos(rig.camera_roll_rad), np.sin(rig.camera_roll_rad)
    right, down = cos * right + sin * down, cos * down - sin * right
    return rig.cx_px + rig.focal_px * right / ahead, rig.cy_px + rig.focal_px * down / ahead


def overlay(frame: Frame, result: FrameResult, axes: Any = None) -> Any:
    """Draws the left image with the outlines of confirmed obstacles on the ground, of moving and near ones upright."""
    axes = axes or plt.subplots()[1]
    axes.imshow(frame.left, cmap="gray", vmin=0, vmax=255)
    for obstacle in result.obstacles:
        if not obstacle.confirmed or obstacle.coasting:
            continue
        points = obstacle.outline[obstacle.outline[:, 0] > 1.0]
        x, y = _closed(points, obstacle).T
        style = {"color": "tab:red" if obstacle.moving else "tab:orange", "linewidth": 1}
        foot = _in_image(result.rig, x, y, 0.0)
        axes.plot(*foot, **style)
        is_near = obstacle.kind == "object" and np.hypot(obstacle.x_m, obstacle.y_m) < NEAR_M
        if obstacle.moving or is_near:
            top = _in_image(result.rig, x, y, obstacle.height_m)
            axes.plot(*top, **style)
            axes.plot(*np.stack([foot, top], 1), **style)
    axes.set_xlim(0, result.rig.width_px)
    axes.set_ylim(result.rig.height_px, 0)
    axes.set_axis_off()
    return axes


def frame(frame: Frame, result: FrameResult) -> Any:
    """Returns a figure of overlay() above grid()."""
    ratios = (result.rig.height_px / result.rig.width_px, result.grid.nx / result.grid.ny)
    figure, (above, below) = plt.subplots(2, 1, figsize=(7, 10), layout="constrained", height_ratios=ratios)
    overlay(frame, result, above)
    grid(result, below)
    return figure
