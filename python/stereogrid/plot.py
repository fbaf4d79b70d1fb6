# SPDX-License-Identifier: Apache-2.0
"""Figures of results with Matplotlib (pip install stereogrid[plot]).

Every function draws into `axes`, or into new ones, and returns them.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from . import Frame, FrameResult, GridGeometry, Obstacle, Pose, Rig, Run

MOVING_MPS = 1.0
"""Cells and obstacles below this speed have no arrow."""
NEAR_M = 10.0
"""Static objects within this distance are drawn with their height."""
FAST_MPS = 15.0
"""Speed of the last colour of tracks()."""
RULER = "#3c82be"


def _extent(grid: GridGeometry) -> tuple[float, float, float, float]:
    """x is drawn upwards and y to the left: left, right, bottom, top."""
    x_min, x_max, y_min, y_max = grid.extent
    return y_min, y_max, x_min, x_max


def centers(grid: GridGeometry) -> tuple[Any, Any]:
    """x and y of the cells' centers, (ny, nx)."""
    x = grid.x_min_m + (np.arange(grid.nx) + 0.5) * grid.cell_size_m
    y = grid.y_min_m + (np.arange(grid.ny) + 0.5) * grid.cell_size_m
    return tuple(np.meshgrid(x, y))


def cells(grid: GridGeometry, values: Any, axes: Any, **style: Any) -> Any:
    """Draws values [iy, ix] of a grid's cells from above; returns the image. style: that of imshow()."""
    image = axes.imshow(np.asarray(values).T, origin="lower", extent=_extent(grid), interpolation="nearest", **style)
    axes.set_xlim(*reversed(_extent(grid)[:2]))
    axes.set_ylim(*_extent(grid)[2:])
    axes.set_xlabel("y (m)")
    axes.set_ylabel("x (m)")
    axes.set_aspect("equal")
    return image


def occupancies(grid: GridGeometry, values: Any, axes: Any) -> Any:
    """Draws probabilities from above: white free, black occupied, grey unknown. Returns the image."""
    return cells(grid, values, axes, cmap="gray_r", vmin=0, vmax=1)


def rulers(rig: Rig, grid: GridGeometry, axes: Any) -> None:
    """Draws the field of view and distances."""
    x_max = grid.extent[1]
    left, right = rig.cx_px / rig.focal_px, (rig.width_px - rig.cx_px) / rig.focal_px
    for slope in (left, -right):
        axes.plot((0, slope * x_max), (0, x_max), color=RULER, linewidth=0.8)
    angles = np.linspace(-np.arctan(right), np.arctan(left), 60)
    step = 20 if x_max > 60 else 5 if x_max > 12 else 1
    for radius in np.arange(step, 1.5 * x_max, step):
        axes.plot(radius * np.sin(angles), radius * np.cos(angles), color=RULER, linewidth=0.8)


def _arrows(axes: Any, result: FrameResult, every: int) -> None:
    vx, vy = result.velocity
    shown = (result.occupancy > 0.5) & (np.hypot(vx, vy) > MOVING_MPS)
    shown[np.arange(shown.shape[0]) % every != 0, :] = False
    shown[:, np.arange(shown.shape[1]) % every != 0] = False
    x, y = centers(result.grid)
    style = {"color": "tab:blue", "angles": "xy", "scale_units": "xy", "scale": 4, "width": 0.004}
    axes.quiver(y[shown], x[shown], vy[shown], vx[shown], **style)


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
    occupancies(result.grid, result.observed if observed else result.occupancy, axes)
    if not observed:
        _arrows(axes, result, every)
    for obstacle in result.obstacles:
        _outline(axes, obstacle)
    axes.set_title(result.name)
    return axes


def elevation(result: FrameResult, axes: Any = None) -> Any:
    """Draws the elevation of the ground, m. Raises ValueError: the pipeline's ground.model is plane."""
    if result.elevation_m is None:
        raise ValueError("elevation: none in the result. Set ground.model to terrain.")
    axes = axes or plt.subplots()[1]
    image = cells(result.grid, result.elevation_m, axes, cmap="terrain")
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


def _to_world(pose: Pose, x_m: float, y_m: float) -> tuple[float, float]:
    c, s = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
    return pose.x_m + c * x_m - s * y_m, pose.y_m + s * x_m + c * y_m


def tracks(run: Run, axes: Any = None, *, frames_min: int = 8) -> Any:
    """Draws the paths of a run's obstacles in the world from above, x to the right.

    Shows confirmed obstacles that were seen in at least frames_min frames. Paths of dynamic ones have the colour of
    their median speed, with id and speed at the end; static ones are dots. Grey: the path of the vehicle.
    """
    axes = axes or plt.subplots(figsize=(12, 6), layout="constrained")[1]
    paths: dict[int, list[tuple[float, float, float, bool]]] = {}
    for frame in run.frames:
        for o in frame.obstacles:
            if o.confirmed and not o.coasting:
                speed = float(np.hypot(o.vx_mps, o.vy_mps))
                paths.setdefault(o.id, []).append((*_to_world(frame.pose, o.x_m, o.y_m), speed, o.moving))
    axes.plot(
        [frame.pose.x_m for frame in run.frames], [frame.pose.y_m for frame in run.frames], color="#bbbbbb", linewidth=5
    )
    for number, path in sorted(paths.items()):
        if len(path) < frames_min:
            continue
        x, y, speeds, moving = zip(*path)
        speed = float(np.median(speeds))
        if speed <= MOVING_MPS or 2 * sum(moving) <= len(path):
            axes.plot(x[-1], y[-1], ".", color="#777777")
            continue
        color = plt.get_cmap("turbo")(speed / FAST_MPS)
        axes.plot(x, y, color=color, linewidth=2)
        axes.plot(x[-1], y[-1], "o", color=color)
        label = f"{number}: {speed:.1f} m/s, {len(path)} frames"
        axes.annotate(label, (x[-1], y[-1]), (5, 5), textcoords="offset points", color=color)
    axes.set_aspect("equal")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    return axes
