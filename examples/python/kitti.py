#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Occupancy grids of a KITTI sequence, or of any other drive: kitti.py DRIVE."""

import sys

import numpy as np

import stereogrid as sg

recording = sg.open(sys.argv[1])
pipeline = sg.Pipeline(sg.preset("default"), recording.rig)
for frame in recording:
    result = pipeline.process(frame)
    for status in result.status:  # conditions that limit the use of the grids
        print(f"{result.name}: {status.name}")
    cells = np.count_nonzero(result.occupancy > 0.5)
    confirmed = [obstacle for obstacle in result.obstacles if obstacle.confirmed]
    nearest = min((obstacle.x_m for obstacle in confirmed), default=float("inf"))
    print(f"{result.name}: {cells} occupied cells, nearest obstacle {nearest:.1f} m ahead")
