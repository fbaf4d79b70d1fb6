# SPDX-License-Identifier: Apache-2.0
"""Makes the input of each source of the tests of paths from a drive. A new source joins by a row of SOURCES."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import numpy as np

import formats
from tables import EXTRINSICS


@dataclass
class Drive:
    """A plain folder, its frames and rig."""

    folder: Path
    scene: str
    first: int
    names: "list[str]"
    stamps_ns: "list[int]"
    poses: "list[tuple[float, float, float]]"
    rig: dict

    def images(self, side: str) -> "list[np.ndarray]":
        return [formats.read_png(self.folder / side / f"{name}.png") for name in self.names]

    @property
    def constant(self) -> float:
        """Focal length in px times baseline in m."""
        return self.rig["focal_px"] * self.rig["baseline_m"]


@dataclass
class Made:
    """Arguments of a run."""

    arguments: "list[str]"
    arrays: "dict[str, str]" = field(default_factory=dict)
    """For Python: argument of process() and the folder of its .npy."""


Disparities = Callable[[], "dict[str, np.ndarray]"]


def _folder(drive: Drive, _: Path, __: Disparities) -> Made:
    return Made([str(drive.folder)])


def _scene(drive: Drive, _: Path, __: Disparities) -> Made:
    return Made([drive.scene, "--frames", f"{drive.first}:"])


def _side_by_side(drive: Drive, out: Path, _: Disparities) -> Made:
    (out / "both").mkdir()
    for name, left, right in zip(drive.names, drive.images("left"), drive.images("right")):
        formats.write_png(out / "both" / f"{name}.png", np.hstack([left, right]))
    for file in ("calibration.yaml", "poses.csv"):
        (out / "both" / file).write_text((drive.folder / file).read_text())
    return Made([str(out / "both"), "--layout", "side-by-side"])


def _bag_of(drive: Drive, out: Path, second: str, images: "list[np.ndarray]", calibration: bool) -> Made:
    messages: list = []
    for i, (stamp_ns, left) in enumerate(zip(drive.stamps_ns, drive.images("left"))):
        for topic, image in (("/stereo/left/image_rect", left), (second, images[i])):
            messages.append((topic, "sensor_msgs/msg/Image", stamp_ns, formats.image_message(stamp_ns, image)))
        for side, baseline_m in (("left", 0.0), ("right", drive.rig["baseline_m"])):
            info = formats.camera_info_message(stamp_ns, drive.rig, baseline_m)
            messages.append((f"/stereo/{side}/camera_info", "sensor_msgs/msg/CameraInfo", stamp_ns, info))
    # one more than images: a pose at the end of an interval is not exact to the bit
    for i, pose in enumerate([*drive.poses, drive.poses[-1]]):
        stamp_ns = drive.stamps_ns[i] if i < len(drive.stamps_ns) else drive.stamps_ns[-1] + 10**8
        messages.append(("/odom", "nav_msgs/msg/Odometry", stamp_ns, formats.odometry_message(stamp_ns, *pose)))
    formats.write_bag(out / "bag.db3", messages)
    more = ["--calibration", str(drive.folder / "calibration.yaml")] if calibration else []
    return Made([str(out / "bag.db3"), *more])


def _bag(drive: Drive, out: Path, _: Disparities) -> Made:
    # CameraInfo has no extrinsics: with these, the drive's own calibration takes its place
    return _bag_of(drive, out, "/stereo/right/image_rect", drive.images("right"), "camera_height_m" in drive.rig)


def _own(drive: Drive, out: Path, disparities: Disparities, file: Callable) -> str:
    """Writes a file for each frame's own disparities."""
    for name, disparity in disparities().items():
        file(out / name, disparity)
    return str(out)


def _save(path: Path, array: np.ndarray) -> None:
    np.save(path.with_suffix(".npy"), array)


def _depth_m(drive: Drive, disparity: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore"):
        depth_m = np.where(disparity > 0, drive.constant / disparity.astype(np.float64), 0)
    return depth_m.astype(np.float32)


def _depth_mm(drive: Drive, disparity: np.ndarray) -> np.ndarray:
    depth_mm = np.rint(1000.0 * _depth_m(drive, disparity))
    return np.where(depth_mm < 2**16, depth_mm, 0).astype(np.uint16)


def _npy(drive: Drive, out: Path, disparities: Disparities) -> Made:
    given = _own(drive, out, disparities, _save)
    return Made([str(drive.folder), "--disparities", given], {"disparity": given})


def _png(drive: Drive, out: Path, disparities: Disparities) -> Made:
    def write(path: Path, disparity: np.ndarray) -> None:
        formats.write_png(path.with_suffix(".png"), np.rint(256 * disparity).astype(np.uint16))

    return Made([str(drive.folder), "--disparities", _own(drive, out, disparities, write)])


def _depth_float(drive: Drive, out: Path, disparities: Disparities) -> Made:
    given = _own(drive, out, disparities, lambda path, disparity: _save(path, _depth_m(drive, disparity)))
    return Made([str(drive.folder), "--depth", given])


def _depth_16(drive: Drive, out: Path, disparities: Disparities) -> Made:
    def write(path: Path, disparity: np.ndarray) -> None:
        formats.write_png(path.with_suffix(".png"), _depth_mm(drive, disparity))

    return Made([str(drive.folder), "--depth", _own(drive, out, disparities, write)])


def _depth_python(drive: Drive, out: Path, disparities: Disparities) -> Made:
    arrays = out / "arrays"
    arrays.mkdir()
    _own(drive, arrays, disparities, lambda path, disparity: _save(path, _depth_mm(drive, disparity)))
    return Made(_depth_16(drive, out, disparities).arguments, {"depth": str(arrays)})


def _depth_bag(drive: Drive, out: Path, disparities: Disparities) -> Made:
    images = [_depth_m(drive, disparity) for disparity in disparities().values()]
    return _bag_of(drive, out, "/stereo/depth/image_rect", images, True)


def _depth_bag_16(drive: Drive, out: Path, disparities: Disparities) -> Made:
    images = [_depth_mm(drive, disparity) for disparity in disparities().values()]
    return _bag_of(drive, out, "/stereo/depth/image_rect", images, True)


def _true(drive: Drive, _: Path, __: Disparities) -> Made:
    return Made([str(drive.folder), "--disparities", str(drive.folder / "truth" / "disparity")])


@dataclass(frozen=True)
class Source:
    make: "Callable[[Drive, Path, Disparities], Made]"
    parent: str
    """Source to compare with; "": none."""
    relation: str
    """To the parent: "same" to the bit, "rounded", "own" disparities as external ones, "true" disparities."""
    command: str = "run"
    """"run", "live" or "python"."""
    extrinsics: "tuple[str, ...]" = EXTRINSICS


SOURCES = {
    "folder": Source(_folder, "", ""),
    "scene": Source(_scene, "folder", "same", extrinsics=("given",)),
    "side_by_side": Source(_side_by_side, "folder", "same"),
    "bag": Source(_bag, "folder", "same"),
    "live": Source(_folder, "folder", "same", "live"),
    "python": Source(_folder, "folder", "same", "python"),
    "npy": Source(_npy, "folder", "own"),
    "npy_live": Source(_npy, "npy", "same", "live"),
    "npy_python": Source(_npy, "npy", "same", "python"),
    "png": Source(_png, "npy", "rounded"),
    "depth_float": Source(_depth_float, "npy", "rounded"),
    "depth_16": Source(_depth_16, "npy", "rounded"),
    "depth_bag": Source(_depth_bag, "depth_float", "same"),
    "depth_bag_16": Source(_depth_bag_16, "depth_16", "same"),
    "depth_python": Source(_depth_python, "depth_16", "same", "python"),
    "true": Source(_true, "folder", "true"),
}


def read_rig(folder: Path) -> dict:
    """calibration.yaml as `simulate` writes it: a line per entry, groups in braces."""
    rig: dict = {}
    for line in (folder / "calibration.yaml").read_text().splitlines():
        text = line.split("#")[0].strip().replace("image: {", "").replace("mount: {", "").rstrip("}")
        for entry in filter(None, text.split(", ")):
            key, value = entry.split(": ")
            rig[key] = float(value) if "_px" not in key or "." in value else int(value)
    return rig


def read_drive(folder: Path, scene: str, first: int) -> Drive:
    lines = (folder / "poses.csv").read_text().splitlines()[1:]
    rows = [line.split(",") for line in lines]
    return Drive(folder, scene, first, [row[0] for row in rows], [int(row[1]) for row in rows],
                 [(float(row[2]), float(row[3]), float(row[4])) for row in rows], read_rig(folder))


def cut_drive(folder: Path, first: int) -> None:
    """Leaves out frames before `first` of what `simulate` has written, and writes poses that lose no digits."""
    truth = folder / "truth" / "objects.jsonl"
    lines = truth.read_text().splitlines()[first:]
    truth.write_text("\n".join(lines) + "\n")
    poses = ["name,stamp_ns,x_m,y_m,yaw_rad"]
    for line in lines:
        frame = json.loads(line)
        ego = frame["ego"]
        poses.append(f"{frame['name']},{frame['stamp_ns']},{ego['x_m']!r},{ego['y_m']!r},{ego['yaw_rad']!r}")
    (folder / "poses.csv").write_text("\n".join(poses) + "\n")
    kept = {pose.split(",")[0] for pose in poses[1:]}
    for side in ("left", "right"):
        for image in (folder / side).iterdir():
            if image.stem not in kept:
                image.unlink()
