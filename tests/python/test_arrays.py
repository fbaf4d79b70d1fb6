# SPDX-License-Identifier: Apache-2.0
"""Arrays in: every type, strides, and what is wrong with them."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from conftest import pipeline_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import stereogrid as sg


def occupancy(scene: sg.Recording, left: Any, right: Any = None, **arguments: Any) -> Any:
    return pipeline_of(scene).process(left, right, **arguments).occupancy


def test_arrays_equal_the_frame(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    by_frame, by_arrays = pipeline_of(scene), pipeline_of(scene)
    for frame in frames:
        expected = by_frame.process(frame)
        assert frame.right is not None
        result = by_arrays.process(frame.left, frame.right, stamp_ns=frame.stamp_ns, pose=frame.pose)
        np.testing.assert_array_equal(result.occupancy, expected.occupancy)
        assert result.stamp_ns == frame.stamp_ns and result.pose == expected.pose


@pytest.mark.parametrize(
    "change",
    [
        lambda image: np.asfortranarray(image),
        lambda image: np.ascontiguousarray(image[:, ::-1])[:, ::-1],
        lambda image: np.ascontiguousarray(image[::-1])[::-1],
        lambda image: np.repeat(np.repeat(image, 2, 0), 3, 1)[::2, ::3],
        lambda image: np.repeat(image[:, :, None], 3, 2)[:, :, 1],
        lambda image: np.pad(image, ((0, 0), (5, 9)))[:, 5:-9],
        lambda image: image.astype(np.uint16) << 8,
        lambda image: image.astype(np.float32),
        lambda image: image.astype(np.float64)[::-1][::-1],
        lambda image: image.tolist() and np.lib.stride_tricks.as_strided(image.copy(), image.shape, image.strides),
    ],
)
def test_equal_pixels_give_equal_results(change: Any, scene: sg.Recording, frames: list[sg.Frame]) -> None:
    left, right = frames[0].left, frames[0].right
    expected = occupancy(scene, left, right)
    np.testing.assert_array_equal(occupancy(scene, change(left), change(right)), expected)


def test_images_are_not_kept(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    expected, pipeline = pipeline_of(scene), pipeline_of(scene)
    left, right = np.empty_like(frames[0].left), np.empty_like(frames[0].left)
    references = sys.getrefcount(left)
    for frame in frames:
        left[:], right[:] = frame.left, frame.right
        result = pipeline.process(left, right, stamp_ns=frame.stamp_ns, pose=frame.pose)
        assert sys.getrefcount(left) == references
        left[:] = right[:] = 0
        np.testing.assert_array_equal(result.occupancy, expected.process(frame).occupancy)


def test_bits_and_color(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    left, right = frames[0].left, frames[0].right
    assert right is not None
    expected = occupancy(scene, left, right)
    twelve = [image.astype(np.uint16) << 4 for image in (left, right)]
    np.testing.assert_array_equal(occupancy(scene, *twelve, bits=12), expected)
    with pytest.warns(RuntimeWarning, match="left: the brightest sample uses 12 of 16 bits. Give bits=12"):
        occupancy(scene, *twelve)
    color = [np.repeat(image[:, :, None], 3, 2) for image in (left, right)]
    np.testing.assert_array_equal(occupancy(scene, *color, color="rgb"), expected)
    with pytest.raises(ValueError, match="color '' of an image with channels"):
        occupancy(scene, *color)


def test_broadcast_rows(scene: sg.Recording) -> None:
    rows = np.broadcast_to(np.arange(256, dtype=np.uint8), (160, 256))
    np.testing.assert_array_equal(occupancy(scene, rows, rows), occupancy(scene, rows.copy(), rows.copy()))


def test_disparity_and_depth(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    truth = frames[0].truth.disparity
    assert truth is not None
    expected = occupancy(scene, frames[0].left, disparity=truth)
    assert (expected > 0.55).any()
    np.testing.assert_array_equal(occupancy(scene, frames[0].left, disparity=truth.astype(np.float64)), expected)
    holes = np.where(truth > 0, truth, np.nan)
    np.testing.assert_array_equal(occupancy(scene, frames[0].left, disparity=holes), expected)
    with np.errstate(divide="ignore"):
        depth = scene.rig.focal_px * scene.rig.baseline_m / truth.astype(np.float64)
    by_depth = occupancy(scene, frames[0].left, depth=depth)
    assert np.mean(np.abs(by_depth - expected) > 0.05) < 0.01
    millimetres = np.where(np.isfinite(depth), np.minimum(depth * 1000, 65535), 0).astype(np.uint16)
    by_millimetres = occupancy(scene, frames[0].left, depth=millimetres)
    assert np.mean(np.abs(by_millimetres - by_depth) > 0.05) < 0.05
    np.testing.assert_array_equal(occupancy(scene, frames[0].left, depth=millimetres, depth_scale=1000), by_millimetres)


def test_disparity_beside_right(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    first = frames[0]
    assert first.truth.disparity is not None and first.right is not None
    by_disparity = occupancy(scene, first.left, disparity=first.truth.disparity)
    both = occupancy(scene, first.left, first.right, disparity=first.truth.disparity)
    np.testing.assert_array_equal(both, by_disparity)  # without a frame before, nothing has been tracked


def test_other_grids(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    frame = scene[0]
    assert frame.right is not None and frame.other_grids == []
    place = sg.GridGeometry(x_min_m=2, y_min_m=-4, cell_size_m=0.8, nx=12, ny=10)
    cells = np.full(place.shape, 0.9, np.float32)
    grids = [sg.ObservedGrid(place, cells), sg.ObservedGrid(place, cells, confidence=np.full_like(cells, 0.5))]
    fused = occupancy(scene, frame.left, frame.right, pose=frame.pose, other_grids=grids)
    assert (fused > occupancy(scene, frame.left, frame.right, pose=frame.pose)).any()
    frame.other_grids = grids
    del grids
    by_frame = pipeline_of(scene).process(frame)
    np.testing.assert_array_equal(by_frame.occupancy, fused)
    assert frame.other_grids[0].confidence is None
    np.testing.assert_array_equal(frame.other_grids[1].occupancy, cells)
    with pytest.raises(sg.InputError):
        occupancy(scene, frame.left, frame.right, other_grids=[sg.ObservedGrid(place, 2 * cells)])
    with pytest.raises(sg.InputError):
        occupancy(scene, frame.left, frame.right, other_grids=[sg.ObservedGrid(place, cells[1:])])


@pytest.mark.parametrize(
    ("left", "error", "text"),
    [
        (np.zeros((160, 256), np.int16), TypeError, "left: dtype int16 (expected uint8, uint16, float32 or float64)"),
        (np.zeros((160, 256), ">u2"), TypeError, "left: dtype >u2"),
        (np.zeros((160, 256), bool), TypeError, "left: dtype bool"),
        (np.zeros((160, 256), complex), TypeError, "left: dtype complex128"),
        (np.zeros((160, 256, 2), np.uint8), ValueError, "left: shape (160, 256, 2) (expected (height, width), or"),
        (np.zeros(160, np.uint8), ValueError, "left: shape (160,)"),
        (np.zeros((0, 256), np.uint8), ValueError, "left: shape (0, 256) has no pixels"),
        (np.zeros((100, 256), np.uint8), sg.InputError, "left has 256 × 100 pixels. The calibration is of 256 × 160."),
        (np.full((160, 256), 0.5), ValueError, "Multiply by 255"),
        (np.full((160, 256), np.nan), ValueError, "allowed 0 to 255"),
        (np.full((160, 256), 256.0), ValueError, "allowed 0 to 255"),
        ("left.png", ValueError, "left: shape ()"),
        (None, TypeError, "left: "),
        ([[1], [2, 3]], TypeError, "left: no array of numbers"),
    ],
)
def test_bad_images(
    left: Any, error: type[Exception], text: str, pipeline: sg.Pipeline, frames: list[sg.Frame]
) -> None:
    with pytest.raises(error) as raised:
        pipeline.process(left, frames[0].right)
    assert text in str(raised.value)
    pipeline.process(frames[0])  # unchanged


def test_bad_disparities(pipeline: sg.Pipeline, frames: list[sg.Frame]) -> None:
    left = frames[0].left
    with pytest.raises(TypeError, match="divide fixed-point disparities by their scale"):
        pipeline.process(left, disparity=np.zeros(left.shape, np.int16))
    with pytest.raises(TypeError, match="depth: dtype uint8"):
        pipeline.process(left, depth=left)
    with pytest.raises(ValueError, match="depth_scale: 0"):
        pipeline.process(left, depth=left.astype(np.uint16), depth_scale=0)
    with pytest.raises(TypeError, match="give right, disparity or depth"):
        pipeline.process(left)
    with pytest.raises(TypeError, match="disparity and depth exclude each other"):
        pipeline.process(left, disparity=left, depth=left)
    with pytest.raises(sg.InputError):
        pipeline.process(left, disparity=np.ones((3, 3), np.float32))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    dtype=st.sampled_from(["u1", "u2", "i2", "i4", "f2", "f4", "f8", "?", "c8", "U1", "M8[s]", "O", ">f4"]),
    shape=st.lists(st.sampled_from([0, 1, 2, 3, 4, 160, 256]), max_size=4),
    step=st.sampled_from([1, 2, -1]),
    what=st.sampled_from(["left", "right", "disparity", "depth", "mask"]),
)
def test_no_array_crashes(
    dtype: str, shape: list[int], step: int, what: str, scene: sg.Recording, frames: list[sg.Frame]
) -> None:
    if np.prod(shape or [1]) > 2_000_000:
        return
    array = np.zeros(shape, dtype)
    array = array[tuple(slice(None, None, step) for _ in shape)]
    pipeline = shared_pipeline(scene)
    arguments: dict[str, Any] = {"left": frames[0].left, "right": frames[0].right}
    if what in ("disparity", "depth"):
        arguments["right"] = None
    try:
        if what == "mask":
            scene.rig.mask = array
        else:
            pipeline.reset()
            pipeline.process(**{**arguments, what: array})
    except (TypeError, ValueError) as error:
        assert str(error)


PIPELINES: list[sg.Pipeline] = []


def shared_pipeline(scene: sg.Recording) -> sg.Pipeline:
    if not PIPELINES:
        PIPELINES.append(pipeline_of(scene))
    return PIPELINES[0]


def test_poses_have_many_forms(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    ahead = np.eye(4)
    ahead[:3, 3] = 0.1, 0, 0.2
    forms = [sg.Pose(0.2, -0.1, 0), (0.2, -0.1, 0), [0.2, -0.1, 0], np.array([0.2, -0.1, 0]), ahead, ahead[:3].tolist()]
    for form in forms:
        assert sg.Frame(frames[0].left, frames[0].right, pose=form).pose == forms[0]
    body = np.eye(4)
    body[:2, :2] = (0.8, -0.6), (0.6, 0.8)
    poses = [(body, "z axis"), (np.zeros((4, 4)), "rotation"), (np.eye(3), "9 numbers"), ([1, 2], "2 numbers")]
    for wrong, what in poses:
        with pytest.raises(ValueError, match=what):
            sg.Frame(frames[0].left, frames[0].right, pose=wrong)
    with pytest.raises(TypeError, match="pose"):
        sg.Frame(frames[0].left, frames[0].right, pose="here")


def test_disparities_of_another_sign_or_scale(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    plane = np.tile(np.linspace(1, 30, scene.rig.height_px, dtype=np.float32)[:, None], (1, scene.rig.width_px))
    with pytest.raises(sg.InputError, match="change the sign"):
        occupancy(scene, frames[0].left, disparity=-plane)
    with pytest.warns(RuntimeWarning, match="matching.disparities"):
        occupancy(scene, frames[0].left, disparity=5 * plane)


def test_warns_once_of_stamps_in_another_unit(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pipeline = pipeline_of(scene)
    with pytest.warns(RuntimeWarning) as warned:
        for i, frame in enumerate(frames[:3]):
            assert frame.right is not None
            pipeline.process(frame.left, frame.right, stamp_ns=1_700_000_000 + i, pose=frame.pose)
    assert len([w for w in warned if "nanoseconds" in str(w.message)]) == 1


class CudaInterface:
    """Array that claims to be in a GPU's memory. The emulated GPU's memory is the host's."""

    def __init__(self, array: np.ndarray, **changes: Any) -> None:
        self.array = array
        host = array.__array_interface__
        of_device = {key: host[key] for key in ("shape", "typestr", "data", "strides")}
        self.__cuda_array_interface__ = of_device | {"version": 3, "stream": 1} | changes


class Dlpack:
    """Likewise by DLPack; `device` 1: an array of the emulated GPU on the host."""

    def __init__(self, source: Any, device: int = 2) -> None:
        self.source, self.device = source, device

    def __dlpack_device__(self) -> tuple[int, int]:
        return self.device, 0

    def __dlpack__(self, **_: Any) -> Any:
        capsule = self.source.__dlpack__()
        pointer = ctypes.pythonapi.PyCapsule_GetPointer
        pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
        ctypes.c_int32.from_address(pointer(capsule, b"dltensor") + ctypes.sizeof(ctypes.c_void_p)).value = self.device
        return capsule


def on_host(array: Any) -> np.ndarray:
    assert array.__dlpack_device__() == (2, 0)
    values = np.from_dlpack(Dlpack(array, device=1))
    assert array.__cuda_array_interface__["data"] == (values.ctypes.data, False)
    assert array.__cuda_array_interface__["shape"] == values.shape == array.shape
    return values


@pytest.fixture
def small_scene() -> sg.Recording:
    return sg.simulate("street?frames=3&width=96&height=64&focal=77")


@pytest.fixture
def gpu(small_scene: sg.Recording, monkeypatch: pytest.MonkeyPatch) -> sg.Pipeline:
    library = os.environ.get("STEREOGRID_EMULATED_CUDA_LIBRARY", "")
    if not library:
        pytest.skip("the emulated GPU is not built")
    monkeypatch.setenv("STEREOGRID_CUDA_LIBRARY", library)
    return sg.Pipeline(small_config(), small_scene.rig, device="cuda")


def small_config() -> sg.Config:
    config = sg.preset("default")
    config.grid.length_m, config.grid.width_m, config.grid.cell_size_m = 10, 8, 0.5
    config.matching.disparities, config.filter.speeds_mps = 16, [1.25]
    return config


@pytest.mark.parametrize("on_gpu", [CudaInterface, Dlpack])
def test_arrays_of_a_gpu(on_gpu: Callable[..., Any], gpu: sg.Pipeline, small_scene: sg.Recording) -> None:
    cpu = sg.Pipeline(small_config(), small_scene.rig, device="cpu")
    for i, frame in enumerate(small_scene):
        assert frame.right is not None
        left, right = (np.pad(image, ((0, 0), (0, 7)))[:, :-7] for image in (frame.left, frame.right))
        of_right: dict[str, Any] = {"disparity": np.full(left.shape, 5, np.float32)} if i == 1 else {"right": right}
        on_device = {name: on_gpu(image) for name, image in of_right.items()}
        result = gpu.process(on_gpu(left), **on_device, stamp_ns=frame.stamp_ns, pose=frame.pose)
        expected = cpu.process(left, **of_right, stamp_ns=frame.stamp_ns, pose=frame.pose)
        assert result.stamp_ns == frame.stamp_ns and (result.observed != 0.5).any()
        grids = gpu.device_grids()
        np.testing.assert_array_equal(on_host(grids.observed), expected.observed)
        for layers, filtered in ((grids.vehicle, expected), (grids.world, expected.world)):
            values = on_host(layers)
            np.testing.assert_array_equal(values[0], filtered.occupancy)
            np.testing.assert_array_equal(values[1:3], filtered.velocity)
            np.testing.assert_array_equal(values[3], filtered.age_s)
            np.testing.assert_array_equal(values[4:7], filtered.velocity_covariance)
            np.testing.assert_array_equal(values[7], filtered.moving)
            ctypes.memset(values.ctypes.data, 0x41, values.nbytes)  # the next frame does not read them


def test_arrays_of_a_gpu_keep_its_memory(gpu: sg.Pipeline, small_scene: sg.Recording) -> None:
    result = gpu.process(small_scene[0])
    references = sys.getrefcount(gpu)
    vehicle = on_host(gpu.device_grids().vehicle)
    gc.collect()
    assert sys.getrefcount(gpu) > references
    np.testing.assert_array_equal(vehicle[0], result.occupancy)
    del vehicle
    assert sys.getrefcount(gpu) == references


def test_arrays_of_a_gpu_that_cannot_be_used(small_scene: sg.Recording) -> None:
    cpu = sg.Pipeline(small_config(), small_scene.rig, device="cpu")
    left, right = (np.zeros((64, 96), np.uint8) for _ in range(2))
    image = CudaInterface(right)
    for on_gpu in (CudaInterface, Dlpack):
        with pytest.raises(sg.ConfigError, match="has no device memory"):
            cpu.process(on_gpu(left), on_gpu(right))
    with pytest.raises(sg.ConfigError, match="has no device memory"):
        cpu.device_grids()
    with pytest.raises(TypeError, match="right: in the host's memory"):
        cpu.process(image, right)
    with pytest.raises(TypeError, match="left: in the host's memory"):
        cpu.process(left, disparity=image)
    with pytest.raises(TypeError, match="images in a GPU's memory: depth or color"):
        cpu.process(image, depth=CudaInterface(right.astype(np.float32)))
    with pytest.raises(TypeError, match="left: dtype <f8 in a GPU's memory"):
        cpu.process(CudaInterface(left.astype(float)), image)
    with pytest.raises(TypeError, match="disparity: dtype uint16 in a GPU's memory"):
        cpu.process(image, disparity=Dlpack(left.astype(np.uint16)))
    for shape in (np.repeat(left, 2, 1)[:, ::2], np.zeros((64, 96, 3), np.uint8)):
        with pytest.raises(ValueError, match="left: not"):
            cpu.process(CudaInterface(shape), image)
    with pytest.raises(sg.InputError, match="pixels"):
        cpu.process(CudaInterface(left[:50]), image)
    with pytest.raises(ValueError, match="right: on another stream"):
        cpu.process(image, CudaInterface(right, stream=2))
    for strides in ((), (1,), (96, 1, 1)):
        with pytest.raises(ValueError, match="left: not"):
            cpu.process(CudaInterface(left, strides=strides), image)
    for wrong in ({"shape": None}, {"data": None}, {"typestr": 1}, {"stream": "x"}):
        with pytest.raises(TypeError, match="left: neither DLPack nor a valid __cuda_array_interface__"):
            cpu.process(CudaInterface(left, **wrong), image)
