#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores grids by where the vehicle drove later: those cells were drivable, whatever a lidar or a label says of them.

score_lane.py [--set NAME=VALUE ...] DATA...      DATA: a recording with poses

The lane is 1.8 m wide around the way of the left camera, 4 to 13 m ahead. Another vehicle that was there in between
counts against the grid. Free is P(occupied) < 0.45, occupied P > 0.55; drives of which no cell is scored have no row.
"""
import argparse
import pathlib

import numpy as np

import stereogrid as sg

HALF_WIDTH_M = 0.9
BEGIN_M, END_M = 4, 13


def cells_of_lane(grid, way):
    """Mask (ny, nx) of the cells on a way, whose points (x, y) are in the vehicle frame of the grid."""
    ahead = way[np.maximum.accumulate(way[:, 0]) == way[:, 0]]  # up to where it turns back
    y, x = np.mgrid[0:grid.ny, 0:grid.nx]
    x = grid.x_min_m + (x + 0.5) * grid.cell_size_m
    y = grid.y_min_m + (y + 0.5) * grid.cell_size_m
    beside_m = np.abs(y - np.interp(x, ahead[:, 0], ahead[:, 1]))
    return (beside_m < HALF_WIDTH_M) & (x >= BEGIN_M) & (x < min(END_M, ahead[-1, 0]))


def print_rows(data, config):
    recording = sg.open(data)
    pipeline = sg.Pipeline(config, recording.rig, stages=False)
    frames = []
    for frame in recording:
        result = pipeline.process(frame)
        grids = {"observed": result.observed.copy(), "occupancy": result.occupancy.copy()}
        frames.append((result.pose, result.grid, grids))
    places = np.array([(pose.x_m, pose.y_m) for pose, _, _ in frames])
    values = {"observed": [], "occupancy": []}
    for i, (pose, grid, grids) in enumerate(frames):
        c, s = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
        lane = cells_of_lane(grid, (places[i:] - places[i]) @ np.array([[c, -s], [s, c]]))
        for name, grid_values in grids.items():
            values[name].append(grid_values[lane])
    for name, parts in values.items():
        p = np.concatenate(parts)
        if len(p) > 0:
            shares = f"{(p < 0.45).mean():.4f} | {(p > 0.55).mean():.4f}"
            print(f"| {pathlib.Path(data).name} | {name} | {len(p)} | {shares} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", nargs="+")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE")
    arguments = parser.parse_args()
    config = sg.preset("default")
    for setting in arguments.set:
        config.set(*setting.split("=", 1))
    print("| input | grid | cells | free | occupied |")
    print("|" + "---|" * 5)
    for data in arguments.data:
        print_rows(data, config)


if __name__ == "__main__":
    main()
