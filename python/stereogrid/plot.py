# SPDX-License-Identifier: Apache-2.0
"""Figures of results with Matplotlib (pip install stereogrid[plot]).

Every function draws into `axes`, or into new ones, and returns them.
"""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from . import Frame, FrameResult, GridGeometry, Obstacle, Pose, Rig, Run

COLORS = {
    "cell-free": "#ffffff",
    "cell-unknown": "#cfd4dd",
    "cell-occupied": "#1c2230",
    "ink": "#1c2230",
    "ring": "#5b6577",
    "obstacle-thing": "#0b6fb8",
    "obstacle-other": "#6b5b95",
    "obstacle-drop": "#a0209e",
    "heading-0": "#49bfb8",
    "heading-1": "#7effa7",
    "heading-2": "#d9e35d",
    "heading-3": "#e1870a",
    "heading-4": "#a6270b",
    "heading-5": "#7a2a50",
    "heading-6": "#2a22b0",
    "heading-7": "#208cff",
}
"""Those of the viewer's light theme (viewer/theme.css), and of the tool's visualisations."""
OCCUPANCY = LinearSegmentedColormap.from_list(
    "occupancy", [COLORS[f"cell-{state}"] for state in ("free", "unknown", "occupied")]
)
DIRECTIONS = LinearSegmentedColormap.from_list("directions", [COLORS[f"heading-{i % 8}"] for i in range(9)], N=360)
"""From 0 (ahead) counter-clockwise to 1 (ahead again); opposite directions differ for colour-blind eyes, too."""
KINDS = {"object": "obstacle-thing", "boundary": "obstacle-other", "drop": "obstacle-drop"}
WIDTHS = {"object": 1.5, "boundary": 1.5, "drop": 3.0}
MOVING_MPS = 1.0
"""Cells below this speed have the color of their occupancy."""
ARROW_S = 1.0
"""Arrows end at the position after this time."""
NEAR_M = 10.0
"""Static objects within this distance are drawn with their height."""
FAST_MPS = 15.0
"""Speed of the last colour of tracks()."""


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
    axes.set_xlabel("y, to the left (m)")
    axes.set_ylabel("x, ahead (m)")
    axes.set_aspect("equal")
    return image


def occupancies(grid: GridGeometry, values: Any, axes: Any) -> Any:
    """Draws probabilities from above: white free, dark occupied, grey unknown. Returns the image."""
    return cells(grid, values, axes, cmap=OCCUPANCY, vmin=0, vmax=1)


def rulers(rig: Rig, grid: GridGeometry, axes: Any) -> None:
    """Draws the field of view and distances."""
    x_max = grid.extent[1]
    left, right = rig.cx_px / rig.focal_px, (rig.width_px - rig.cx_px) / rig.focal_px
    for slope in (left, -right):
        axes.plot((0, slope * x_max), (0, x_max), color=COLORS["ring"], linewidth=0.8)
    angles = np.linspace(-np.arctan(right), np.arctan(left), 60)
    step = 20 if x_max > 60 else 5 if x_max > 12 else 1
    for radius in np.arange(step, 1.5 * x_max, step):
        axes.plot(radius * np.sin(angles), radius * np.cos(angles), color=COLORS["ring"], linewidth=0.8)


def _halo(width: float, color: Any) -> Any:
    """Makes a color readable on any background."""
    is_light = np.dot((0.299, 0.587, 0.114), to_rgb(color)) > 150 / 255
    return [withStroke(linewidth=width, foreground=COLORS["ink" if is_light else "cell-free"])]


def _turns(vx_mps: Any, vy_mps: Any) -> Any:
    return np.arctan2(vy_mps, vx_mps) / (2 * np.pi) % 1


def _moving_cells(result: FrameResult) -> Any:
    """RGB of the cells (nx, ny, 3): direction of those that move, occupancy of the others."""
    vx, vy = result.velocity
    colors = OCCUPANCY(result.occupancy)[..., :3]
    moving = (result.occupancy > 0.6) & (np.hypot(vx, vy) > MOVING_MPS)
    colors[moving] = DIRECTIONS(_turns(vx[moving], vy[moving]))[:, :3]
    return colors.transpose(1, 0, 2)


def _color(obstacle: Obstacle) -> Any:
    if obstacle.moving:
        return DIRECTIONS(_turns(obstacle.vx_mps, obstacle.vy_mps))
    return to_rgb(COLORS[KINDS[obstacle.kind]])


def _style(obstacle: Obstacle) -> dict[str, Any]:
    color, width = _color(obstacle), WIDTHS[obstacle.kind]
    return {"color": color, "linewidth": width, "path_effects": _halo(width + 1.5, color)}


def _label(axes: Any, obstacle: Obstacle, u: float, v: float) -> None:
    speed = f": {np.hypot(obstacle.vx_mps, obstacle.vy_mps):.1f} m/s" if obstacle.moving else ""
    style = {
        "ha": "center",
        "va": "bottom",
        "fontsize": "small",
        "clip_on": True,
        "path_effects": _halo(2.5, COLORS["ink"]),
    }
    axes.text(u, v, f"{obstacle.id}{speed}", color=COLORS["ink"], **style)


def legend(axes: Any) -> None:
    """Draws the kinds of lines below a grid, and the wheel of directions."""
    lines = [Line2D([], [], color=COLORS[color], linewidth=WIDTHS[kind], label=kind) for kind, color in KINDS.items()]
    arrow = Line2D([], [], color=COLORS["ink"], marker=">", label=f"motion in {ARROW_S:g} s")
    axes.legend(handles=[*lines, arrow], loc="upper left", bbox_to_anchor=(0, -0.1), ncols=2, frameon=False)
    wheel = axes.inset_axes((0.8, -0.3, 0.2, 0.2), projection="polar", theta_offset=np.pi / 2)
    angles = np.linspace(0, 2 * np.pi, 73)
    wheel.pcolormesh(angles, [0.5, 1], np.arange(72)[None] / 72, cmap=DIRECTIONS, vmin=0, vmax=1)
    wheel.set_ylim(0, 1)
    wheel.set_xticks(np.arange(4) * np.pi / 2, ["ahead", "left", "back", "right"], fontsize="small")
    wheel.tick_params(pad=0)
    wheel.set_yticks([])
    wheel.grid(False)
    wheel.spines["polar"].set_visible(False)


def _closed(points: Any, obstacle: Obstacle) -> Any:
    return np.vstack([points, points[:1]]) if obstacle.kind == "object" else points


def _outline(axes: Any, obstacle: Obstacle) -> None:
    points = _closed(obstacle.outline, obstacle)
    style = _style(obstacle)
    axes.plot(points[:, 1], points[:, 0], **style)
    if obstacle.moving:
        tip = (obstacle.y_m + ARROW_S * obstacle.vy_mps, obstacle.x_m + ARROW_S * obstacle.vx_mps)
        style |= {"arrowstyle": "->", "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, (obstacle.y_m, obstacle.x_m), arrowprops=style)
    _label(axes, obstacle, obstacle.y_m, obstacle.x_m)


def grid(result: FrameResult, axes: Any = None, *, observed: bool = False) -> Any:
    """Draws the occupancy from above (dark: occupied) as `stereogrid run --pictures` does.

    Moving cells have the colour of their direction. Confirmed obstacles have an outline, their number, and if they
    move an arrow to their position in a second, and their speed. observed: of the frame alone, without velocities.
    """
    axes = axes or plt.subplots(layout="constrained")[1]
    if observed:
        occupancies(result.grid, result.observed, axes)
    else:
        cells(result.grid, np.zeros(result.occupancy.shape), axes).set_data(_moving_cells(result))
    rulers(result.rig, result.grid, axes)
    axes.set_xlim(*reversed(_extent(result.grid)[:2]))
    axes.set_ylim(*_extent(result.grid)[2:])
    for obstacle in result.obstacles:
        if obstacle.confirmed:
            _outline(axes, obstacle)
    legend(axes)
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
    """Draws the left image with the outlines of confirmed obstacles on the ground, of moving and near ones upright.

    Colors and numbers are those of grid().
    """
    axes = axes or plt.subplots()[1]
    axes.imshow(frame.left, cmap="gray", vmin=0, vmax=255)
    for obstacle in result.obstacles:
        if not obstacle.confirmed or obstacle.coasting:
            continue
        points = obstacle.outline[obstacle.outline[:, 0] > 1.0]
        x, y = _closed(points, obstacle).T
        style = _style(obstacle)
        foot = _in_image(result.rig, x, y, 0.0)
        top = _in_image(result.rig, x, y, obstacle.height_m)
        axes.plot(*foot, **style)
        is_near = obstacle.kind == "object" and np.hypot(obstacle.x_m, obstacle.y_m) < NEAR_M
        if obstacle.moving or is_near:
            axes.plot(*top, **style)
            axes.plot(*np.stack([foot, top], 1), **style)
        if len(x) > 0:
            _label(axes, obstacle, top[0].mean(), top[1].min())
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
