#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Grids of disparities that another matcher or a network has found: own_disparities.py DRIVE."""

import sys

import cv2
import numpy as np

import stereogrid as sg

recording = sg.open(sys.argv[1])
matcher = cv2.StereoSGBM.create(numDisparities=64, blockSize=5, P1=200, P2=800, uniquenessRatio=10)
pipeline = sg.Pipeline(sg.preset("default"), recording.rig)
for frame in recording:
    sixteenths = matcher.compute(frame.left, frame.right)  # int16; below 0: none
    disparity = sixteenths.astype(np.float32) / 16
    result = pipeline.process(frame.left, disparity=disparity, stamp_ns=frame.stamp_ns, pose=frame.pose)
    print(f"{frame.name}: {np.count_nonzero(result.occupancy > 0.5)} occupied cells")
