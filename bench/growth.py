#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scaling of time and memory of the default chain from the paper's size on, as Markdown: image width and height,
disparities, cells, velocities, obstacles and threads, one at a time; images and disparities together, up to 1920 × 1080 ·
192. Also the expected gain of more threads by work and span, and frames per second of several cameras. Scene `street`; all
sizes of a row in turns, two threads. The exponent is that of a power law through a row's medians.
"""
import statistics
import threading
import time

import numpy as np
import stereogrid as sg

ROUNDS, FRAMES, WARM_UP = 5, 24, 8
PAPER = {"width": 512, "height": 320, "focal": 410, "disparities": 64, "side_m": 20.0, "speeds": 6, "threads": 2, "posts": 0}
ROWS = (
    ("width, px", [{"width": width} for width in (512, 1024, 2048)], lambda s: s["width"]),
    ("height, px", [{"height": height} for height in (320, 640, 1280)], lambda s: s["height"]),
    ("disparities", [{"disparities": count} for count in (64, 128, 256)], lambda s: s["disparities"]),
    ("million pixels · disparities: 512 × 320 · 64, 1242 × 375 · 128, 1920 × 1080 · 192",
     [{}, {"width": 1242, "height": 375, "focal": 720, "disparities": 128},
      {"width": 1920, "height": 1080, "focal": 1540, "disparities": 192}],
     lambda s: 1e-6 * s["width"] * s["height"] * s["disparities"]),
    ("cells of the grid", [{"side_m": side_m} for side_m in (20.0, 40.0, 80.0)], lambda s: 25 * s["side_m"] ** 2),
    ("velocities", [{"speeds": count} for count in (3, 6, 12)], lambda s: (2 * s["speeds"] + 1) ** 2),
    ("obstacles, without matching", [{"posts": count} for count in (4, 16, 64)], lambda s: s["posts"]),
    ("threads", [{"threads": count} for count in (1, 2)], lambda s: s["threads"]),
)


def config_of(setting: dict) -> sg.Config:
    config = sg.preset("default")
    config.matching.disparities = setting["disparities"]
    config.grid.length_m = config.grid.width_m = setting["side_m"]
    speeds = list(config.filter.speeds_mps)
    speeds += [speeds[-1] + 2 * (i + 1) for i in range(setting["speeds"] - len(speeds))]
    config.filter.speeds_mps = speeds[:setting["speeds"]]
    return config


def disparities_of_posts(rig: sg.Rig, posts: int) -> np.ndarray:
    """Disparities of a road with posts of 0.1 to 0.2 m, in turns at 10 and 14 m, side by side."""
    v, u = np.mgrid[0:rig.height_px, 0:rig.width_px]
    distance_m = np.where(u // 8 % 2 == 0, 10.0, 14.0)
    height_m = rig.camera_height_m - (v - rig.cy_px) * distance_m / rig.focal_px
    is_post = (u // 8 < posts) & (u % 8 < 4) & (height_m > 0) & (height_m < 1.5)
    depth_m = np.where(is_post, distance_m, rig.camera_height_m * rig.focal_px / np.maximum(v - rig.cy_px, 1e-3))
    disparity = rig.focal_px * rig.baseline_m / depth_m
    return np.where(disparity >= 1, disparity, 0).astype(np.float32)


def frames_of(setting: dict) -> tuple:
    recording = sg.simulate(f"street?frames={FRAMES}&width={setting['width']}&height={setting['height']}&focal={setting['focal']}")
    frames = list(recording)
    if setting["posts"]:
        disparity = disparities_of_posts(recording.rig, setting["posts"])
        frames = [sg.Frame(frames[0].left, None, frame.stamp_ns, frames[0].pose, disparity=disparity) for frame in frames]
    return recording.rig, frames


def drive(setting: dict, rig: sg.Rig, frames: list, times_ms: list) -> int:
    pipeline = sg.Pipeline(config_of(setting), rig, threads=setting["threads"], stages=False)
    for i, frame in enumerate(frames):
        result = pipeline.process(frame)
        # wide images see obstacles beside the vehicle that are too close
        if result.warnings and [status.name for status in result.status] != ["too_close"]:
            raise RuntimeError(f"not what is measured: {result.warnings[0]}")
        if i >= WARM_UP:
            times_ms.append(result.timing_ms["total"])
    return pipeline.memory_bytes


def print_row(name: str, changes: list, size) -> list:
    """Returns the times of each size."""
    settings = [PAPER | change for change in changes]
    inputs = [frames_of(setting) for setting in settings]
    times_ms = [[] for _ in settings]
    for _ in range(ROUNDS):
        used = [drive(setting, *given, times) for setting, given, times in zip(settings, inputs, times_ms)]
    sizes, medians = [size(setting) for setting in settings], [statistics.median(times) for times in times_ms]
    exponents = [np.polyfit(np.log(sizes), np.log(values), 1)[0] for values in (medians, used)]
    print(f"| {name} | {' / '.join(f'{value:.0f}' for value in sizes)} | {' / '.join(f'{value:.1f}' for value in medians)} "
          f"| {exponents[0]:.2f} | {' / '.join(f'{value / 1e6:.0f}' for value in used)} | {exponents[1]:.2f} |", flush=True)
    return times_ms


def camera_rate(cameras: int, in_turns: bool, rig: sg.Rig, frames: list) -> float:
    """Frames per second of all cameras."""
    pipelines = [sg.Pipeline(sg.preset("default"), rig, stages=False) for _ in range(cameras)]
    begin = 0.0
    for i, frame in enumerate(frames):
        if i == WARM_UP:
            begin = time.perf_counter()
        if in_turns:
            for pipeline in pipelines:
                pipeline.process(frame)
            continue
        threads = [threading.Thread(target=pipeline.process, args=(frame,)) for pipeline in pipelines]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return cameras * (len(frames) - WARM_UP) / (time.perf_counter() - begin)


def main() -> None:
    print("| what grows | sizes | median ms | exponent | MB | exponent |\n|---|---|---|---|---|---|")
    for row in ROWS:
        times_ms = print_row(*row)
    one_ms, two_ms = map(min, times_ms)
    span_ms = max(2 * two_ms - one_ms, 0.0)  # T(p) = work/p + span
    print("\n| threads | ms, computed | faster than one |\n|---|---|---|")
    for threads in (4, 8):
        ms = (one_ms - span_ms) / threads + span_ms
        print(f"| {threads} | {ms:.1f} | {one_ms / ms:.1f} |")
    rig, frames = frames_of(PAPER)
    print("\n| cameras | frames/s of all, in turns | a thread each |\n|---|---|---|")
    for cameras in (1, 2, 4, 8):
        best = [max(camera_rate(cameras, in_turns, rig, frames) for _ in range(ROUNDS)) for in_turns in (True, False)]
        print(f"| {cameras} | {best[0]:.0f} | {best[1]:.0f} |", flush=True)


if __name__ == "__main__":
    main()
