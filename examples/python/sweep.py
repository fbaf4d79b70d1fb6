#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A parameter's effect on the grids of a scene, on all cores: sweep.py KEY VALUE..."""

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

import numpy as np

import stereogrid as sg


def score(key: str, value: str) -> float:
    """Share of the visible cells whose occupancy is on the wrong side of 0.5."""
    config = sg.preset("default")
    config.set(key, value)
    scene = sg.simulate("crossing", frames=10)
    pipeline = sg.Pipeline(config, scene.rig, threads=1)  # one thread for each process
    for frame in scene:
        result = pipeline.process(frame)
    state = frame.truth.state
    assert state is not None and state.shape == result.occupancy.shape
    return float(np.mean((result.occupancy > 0.5)[state > 0] != (state == 2)[state > 0]))


if __name__ == "__main__":
    key, *values = sys.argv[1:]
    # spawn: a forked process has none of the library's threads
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for value, wrong in zip(values, pool.map(partial(score, key), values)):
            print(f"{key}={value}: {100 * wrong:.2f} % wrong")
