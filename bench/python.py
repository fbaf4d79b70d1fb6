#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Time that a frame takes outside the pipeline's own clock (timing_ms.total), in C++ and in Python in turns, as Markdown:
checks, call and release of the previous result.

python.py LIBRARY    LIBRARY: libbench_python.so of a build with STEREOGRID_BENCH and STEREOGRID_PYTHON
"""
import ctypes
import statistics
import sys
import time

import stereogrid as sg

SIZES = ("width=512&height=320&focal=410", "width=1242&height=375&focal=720")
FRAMES, WARM_UP, ROUNDS = 40, 8, 5


def outside_us(pipeline: sg.Pipeline, *arguments, **options) -> float:
    global result  # the previous one is released within the time
    clock = time.perf_counter
    begin = clock()
    result = pipeline.process(*arguments, **options)
    return 1e6 * (clock() - begin) - 1e3 * result.timing_ms["total"]


def measure(library: ctypes.CDLL, scene: str) -> dict:
    recording = sg.simulate(scene)
    frames = list(recording)
    pairs = [(frame.left.copy(), frame.right.copy()) for frame in frames]
    height, width = pairs[0][0].shape
    addresses = [[ctypes.c_void_p(image.ctypes.data) for image in pair] for pair in pairs]
    times = {"C++, `process(frame, images, into)`": [], "Python, `process(left, right)`": [], "Python, `process(frame)`": []}
    for _ in range(ROUNDS):
        loop = library.make_loop(scene.encode())
        arrays, loaded = (sg.Pipeline(sg.preset("default"), recording.rig, threads=1) for _ in range(2))
        found = ([library.frame_us(loop, *pair, width, height, frame.stamp_ns) for pair, frame in zip(addresses, frames)],
                 [outside_us(arrays, *pair, stamp_ns=frame.stamp_ns) for pair, frame in zip(pairs, frames)],
                 [outside_us(loaded, frame) for frame in frames])
        library.delete_loop(loop)
        for of_loop, values in zip(times.values(), found):
            of_loop += values[WARM_UP:]
    return times


def main() -> None:
    library = ctypes.CDLL(sys.argv[1])
    library.make_loop.restype = ctypes.c_void_p
    library.delete_loop.argtypes = [ctypes.c_void_p]
    library.frame_us.restype = ctypes.c_double
    library.frame_us.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_int] * 2 + [ctypes.c_int64]
    for size in SIZES:
        print(f"**{size.replace('&', ', ')}**\n\n| frame | least µs | median µs |\n|---|---|---|")
        for name, found in measure(library, f"street?frames={FRAMES}&{size}").items():
            print(f"| {name} | {min(found):.0f} | {statistics.median(found):.0f} |", flush=True)
        print()


if __name__ == "__main__":
    main()
