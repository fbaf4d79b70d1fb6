# SPDX-License-Identifier: Apache-2.0
"""The GIL, threads and memory."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from conftest import pipeline_of

import stereogrid as sg


def occupancies(recording: sg.Recording) -> list[Any]:
    pipeline = pipeline_of(recording, threads=1)
    return [pipeline.process(frame).occupancy for frame in recording]


def test_pipelines_in_threads_do_not_disturb_each_other(scene: sg.Recording) -> None:
    expected = occupancies(scene)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(occupancies, [scene] * 8):
            np.testing.assert_array_equal(found, expected)


def test_one_pipeline_in_two_threads_is_an_error(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pipeline = pipeline_of(scene, threads=1)
    errors: list[Exception] = []
    ended = threading.Event()

    def work() -> None:
        while not ended.is_set():
            try:
                pipeline.reset()
                pipeline.process(frames[0])
            except RuntimeError as error:
                errors.append(error)
                ended.set()

    workers = [threading.Thread(target=work) for _ in range(2)]
    for worker in workers:
        worker.start()
    ended.wait(30)
    ended.set()
    for worker in workers:
        worker.join()
    assert errors and "in use by another thread" in str(errors[0])
    pipeline.reset()
    pipeline.process(frames[0])


def test_the_gil_is_released(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    pipeline = sg.Pipeline(sg.preset("default"), scene.rig, device="reference")
    ticks, times = 0, []

    def work() -> None:
        start = time.perf_counter()
        pipeline.process(frames[0])
        times.append(time.perf_counter() - start)

    worker = threading.Thread(target=work)
    worker.start()
    while worker.is_alive():
        ticks += 1
        time.sleep(0.001)
    assert (times and ticks > 5) or times[0] < 0.01


AT_EXIT = """
import os, threading, time
import stereogrid as sg
recording = sg.simulate("street", frames=2, width_px=256, height_px=160)
frames = list(recording)
begun = threading.Event()

def process():
    pipeline = sg.Pipeline(sg.preset("default"), recording.rig, device="{device}")
    while True:
        for index, frame in enumerate(frames):
            if index == 0:
                pipeline.reset()
            pipeline.process(frame)
            begun.set()

def iterate():
    while True:
        list(recording)
        begun.set()

threading.Thread(target={work}, daemon=True).start()
begun.wait()
{end}
"""

IN_FORK = """
child = os.fork()
if child != 0:
    raise SystemExit(os.waitpid(child, 0)[1])
"""


@pytest.mark.parametrize("work, device", [("process", "cpu"), ("process", "reference"), ("iterate", "cpu")])
@pytest.mark.parametrize("end, code", [("time.sleep(0.05)", 0), ("raise SystemExit(3)", 3), (IN_FORK, 0)])
def test_the_interpreter_ends_during_a_call(work: str, device: str, end: str, code: int) -> None:
    program = AT_EXIT.format(work=work, device=device, end=end)
    ended = subprocess.run([sys.executable, "-W", "ignore", "-c", program], capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr) == (code, "", "")


def last_occupancy(length_m: float) -> Any:
    recording = sg.simulate("street", frames=2, width_px=256, height_px=160)
    config = sg.preset("default")
    config.grid.length_m = length_m
    pipeline = sg.Pipeline(config, recording.rig, device="cpu", threads=1)
    return [pipeline.process(frame) for frame in recording][-1].occupancy


def test_processes() -> None:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        shapes = [array.shape for array in pool.map(last_occupancy, [10.0, 16.0])]
    assert shapes == [(100, 50), (100, 80)]


def memory_kib() -> int:
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_memory_does_not_grow(scene: sg.Recording, frames: list[sg.Frame]) -> None:
    config = sg.preset("default")
    config.grid.length_m = config.grid.width_m = 8
    pipeline = sg.Pipeline(config, scene.rig, device="cpu")
    frame_count = int(os.environ.get("STEREOGRID_SOAK_FRAMES", "300"))
    kept: list[Any] = []

    def run(count: int, stamp: int) -> int:
        for _ in range(count):
            frame = frames[stamp % len(frames)]
            result = pipeline.process(frame.left, frame.right, stamp_ns=stamp * 100_000_000)
            kept.append(result.velocity)
            kept.append(result.stages.visible)
            result.obstacles  # noqa: B018
            del kept[:-8]
            stamp += 1
        return stamp

    stamp = run(frame_count // 2, 0)
    before = memory_kib()
    run(frame_count, stamp)
    grown = memory_kib() - before
    assert grown < 8 * 1024, f"{grown} KiB in {frame_count} frames"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss > 0
