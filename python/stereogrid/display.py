# SPDX-License-Identifier: Apache-2.0
"""Texts, tables and images of objects in interpreters and notebooks. Importing stereogrid installs them."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping
from typing import Any

from . import _core

FIELDS: dict[type, tuple[str, ...]] = {
    _core.FrameIterator: (),
    _core.FrameTruth: ("name", "stamp_ns", "ego", "state", "objects"),
    _core.GridLayers: ("grid", "occupancy"),
    _core.Ground: ("height_m", "pitch_rad", "roll_rad", "estimated"),
    _core.ObservedGrid: ("grid", "occupancy"),
    _core.Pipeline: ("grid", "device", "threads"),
    _core.Prediction: ("horizon_s", "occupancy"),
    _core.Run: ("folder", "preset", "frames"),
    _core.RunFrame: ("index", "name", "stamp_ns", "pose", "obstacles"),
    _core.RunGrids: ("occupancy",),
    _core.RunWriter: ("folder",),
    _core.StageImages: ("obstacle_disparity", "visible"),
    _core.TruthEgo: ("pose", "vx_mps", "vy_mps", "yaw_rate_radps"),
    _core.TruthGrid: ("grid", "height_min_m", "height_max_m"),
    _core.TruthObject: ("id", "kind", "pose", "vx_mps", "vy_mps"),
}
"""Fields that the text of an object names. Other classes have texts of their own."""


_CONFIG = _core.Config()
for _key in _core.Config.keys():
    _group, _name = _key.split(".")
    _kind = type(getattr(_CONFIG, _group))
    FIELDS[_kind] = (*FIELDS.get(_kind, ()), _name)


def _value(value: Any) -> str:
    if hasattr(value, "dtype"):
        return f"<{value.dtype} {'x'.join(map(str, value.shape))}>"
    return f"<{len(value)}>" if isinstance(value, list) else repr(value)


def text(self: Any) -> str:
    """Returns such as "Ground(height_m=1.65, …)"; arrays as <type and shape>, lists as <length>."""
    fields = (f"{name}={_value(getattr(self, name))}" for name in FIELDS[type(self)])
    return f"{type(self).__name__}({', '.join(fields)})"


def _png(draw: Any, width_in: float, height_in: float) -> bytes | None:
    """PNG of a figure that draw(axes) fills; None: Matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError:
        return None
    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    draw(figure.subplots())
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=80)
    return file.getvalue()


def frame_png(self: _core.Frame) -> bytes | None:
    """PNG of the left image; None: Matplotlib is not installed."""

    def draw(axes: Any) -> None:
        axes.imshow(self.left, cmap="gray", vmin=0, vmax=255)
        axes.set_axis_off()

    height, width = self.left.shape
    return _png(draw, 8, 8 * height / width)


def result_png(self: _core.FrameResult) -> bytes | None:
    """PNG of plot.grid(); None: Matplotlib is not installed."""

    def draw(axes: Any) -> None:
        from . import plot

        plot.grid(self, axes)

    return _png(draw, 6, 6 * self.grid.nx / self.grid.ny)


def _page(rows: Mapping[str, object], png: bytes | None) -> str:
    """HTML of a table of two columns, with an image below."""
    cells = "".join(f"<tr><th>{name}</th><td>{html.escape(str(value))}</td></tr>" for name, value in rows.items())
    image = f'<img src="data:image/png;base64,{base64.b64encode(png).decode()}">' if png else ""
    return f"<table>{cells}</table>{image}"


def frame_html(self: _core.Frame) -> str:
    """Stamp, size and pose of a frame, and its left image."""
    images = [name for name in ("left", "right", "disparity") if getattr(self, name) is not None]
    height, width = self.left.shape
    rows = {"frame": self.name, "stamp_ns": self.stamp_ns, "images": f"{', '.join(images)} of {width} x {height} px"}
    return _page({**rows, "pose": self.pose}, frame_png(self))


def result_html(self: _core.FrameResult) -> str:
    """Obstacles, status, warnings and time of a result, and its grid."""
    moving = sum(obstacle.moving for obstacle in self.obstacles)
    rows = {
        "frame": self.name,
        "grid": f"{self.grid.nx} x {self.grid.ny} cells of {self.grid.cell_size_m:g} m",
        "obstacles": f"{len(self.obstacles)}, {moving} moving",
        "status": ", ".join(status.name for status in self.status) or "ok",
        "warnings": " ".join(self.warnings) or "none",
        "time": f"{self.timing_ms['total']:.1f} ms",
    }
    return _page(rows, result_png(self))


def install() -> None:
    """Sets the methods of the classes."""
    for kind in FIELDS:
        kind.__repr__ = text  # type: ignore[assignment]
    methods: dict[type, tuple[Any, Any]] = {
        _core.Frame: (frame_html, frame_png),
        _core.FrameResult: (result_html, result_png),
    }
    for kind, (page, png) in methods.items():
        kind._repr_html_, kind._repr_png_ = page, png  # type: ignore[attr-defined]
