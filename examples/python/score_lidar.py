#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores of a run against the drive's lidar: score_lidar.py RUN [DRIVE]"""

import sys

import stereogrid as sg

run = sg.read_run(sys.argv[1])
figures = sg.evaluate(sys.argv[1], *sys.argv[2:3], truth="lidar")
print(f"{len(run)} frames of preset {run.preset}, cells of {run.grid.cell_size_m} m")
for name, series in figures["series"].items():
    for band, scores in series["bands"].items():
        print(f"{name} {band}:", {key: scores[key]["value"] for key in ("auc", "missed", "false_alarms")})
