#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores predicted grids against the exact truth of their target frame, beside the present grid as a prediction of the
grid of then (a world that stands still).

score_prediction.py DATA...      DATA: a plain folder with truth/

Truth of a later frame is read in the cells that the car sees now. Prints the balanced log-loss and the AUC of all cells that are
then seen, and of those of them that something moving covers now or then.
"""
import pathlib
import sys

import numpy as np

import stereogrid as sg

HORIZONS_S = [0.5, 1, 2]


def cells_then(grid, now, then, truth):
    """Indices (iy, ix) into the truth of `then` of every cell of the grid at `now`; −1 outside."""
    y, x = np.mgrid[0:grid.ny, 0:grid.nx]
    x = grid.x_min_m + (x + 0.5) * grid.cell_size_m
    y = grid.y_min_m + (y + 0.5) * grid.cell_size_m
    c, s = np.cos(now.yaw_rad), np.sin(now.yaw_rad)
    wx, wy = now.x_m + c * x - s * y - then.x_m, now.y_m + s * x + c * y - then.y_m
    c, s = np.cos(then.yaw_rad), np.sin(then.yaw_rad)
    ix = np.floor((c * wx + s * wy - truth.x_min_m) / truth.cell_size_m).astype(int)
    iy = np.floor((-s * wx + c * wy - truth.y_min_m) / truth.cell_size_m).astype(int)
    inside = (ix >= 0) & (ix < truth.nx) & (iy >= 0) & (iy < truth.ny)
    return np.where(inside, iy, -1), np.where(inside, ix, -1)


def read(truth, at):
    inside = at[0] >= 0
    state = np.where(inside, truth.state[at], 0)
    speed = np.hypot(truth.velocity_x, truth.velocity_y)
    return state, inside & (truth.occupied[at] > 0) & (speed[at] > 0.3)


def scores(p, occupied):
    p = np.clip(p, 0.001, 0.999)
    if occupied.all() or not occupied.any():
        return float("nan"), float("nan")
    loss = 0.5 * (-np.log(p[occupied]).mean() - np.log(1 - p[~occupied]).mean())
    order = np.argsort(p, kind="stable")
    values, inverse, counts = np.unique(p[order], return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    ranks = ((last - counts + 1 + last) / 2)[inverse]
    n = occupied.sum()
    auc = (ranks[occupied[order]].sum() - n * (n + 1) / 2) / (n * (len(p) - n))
    return loss, auc


def print_rows(data):
    recording = sg.open(data)
    pipeline = sg.Pipeline(sg.preset("default"), recording.rig, stages=False, horizons_s=HORIZONS_S)
    frames = [(pipeline.process(frame), frame.truth) for frame in recording]
    by_stamp = {round(result.stamp_ns / 1e7): (result, truth) for result, truth in frames}
    grid = recording.truth_grid.grid
    pooled = {}
    for result, truth in frames:
        for ahead in result.predictions:
            then = by_stamp.get(round(result.stamp_ns / 1e7 + ahead.horizon_s * 100))
            if then is None:
                continue
            state, moving = read(then[1], cells_then(result.grid, result.pose, then[0].pose, grid))
            moving |= read(truth, cells_then(result.grid, result.pose, result.pose, grid))[1]
            seen = state > 0
            pooled.setdefault(ahead.horizon_s, []).append(
                (ahead.occupancy[seen], result.occupancy[seen], state[seen] == 2, moving[seen]))
    for horizon_s, parts in sorted(pooled.items()):
        predicted, now, occupied, moving = (np.concatenate(column) for column in zip(*parts))
        row = [data.name, f"{horizon_s:g}", str(len(occupied))]
        for mask in (np.ones_like(moving), moving):
            if mask is moving:
                row.append(str(mask.sum()))
            ours, standing = (scores(p[mask], occupied[mask]) for p in (predicted, now))
            row += [f"{ours[0]:.3f} / {standing[0]:.3f}", f"{ours[1]:.3f} / {standing[1]:.3f}"]
        print("| " + " | ".join(row).replace("nan / nan", "–") + " |")


def main():
    print("| sequence | s | cells | log-loss predicted / standing | AUC | moving: cells | log-loss | AUC |")
    print("|" + "---|" * 8)
    for data in map(pathlib.Path, sys.argv[1:]):
        print_rows(data)


if __name__ == "__main__":
    main()
