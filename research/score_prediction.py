#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Scores predicted grids against the exact truth of their target frame, beside the present grid as a prediction of the
grid of then (a world that stands still).

score_prediction.py TOOL DATA...      DATA: a plain folder with truth/

Truth of a later frame is read in the cells that the car sees now. Prints the balanced log-loss and the AUC of all cells that are
then seen, and of those of them that something moving covers now or then.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np


def pose_of(record):
    pose = record["pose"]
    return pose["x_m"], pose["y_m"], pose["yaw_rad"]


def truth_grid(folder):
    return json.loads((folder / "truth" / "grid.json").read_text())


def cells_then(run_grid, now, then, truth):
    """Indices (iy, ix) into the truth of `then` of every cell of the run's grid at `now`; −1 outside."""
    y, x = np.mgrid[0:run_grid["ny"], 0:run_grid["nx"]]
    x = run_grid["x_min_m"] + (x + 0.5) * run_grid["cell_size_m"]
    y = run_grid["y_min_m"] + (y + 0.5) * run_grid["cell_size_m"]
    c, s = np.cos(now[2]), np.sin(now[2])
    wx, wy = now[0] + c * x - s * y - then[0], now[1] + s * x + c * y - then[1]
    c, s = np.cos(then[2]), np.sin(then[2])
    ix = np.floor((c * wx + s * wy - truth["x_min_m"]) / truth["cell_size_m"]).astype(int)
    iy = np.floor((-s * wx + c * wy - truth["y_min_m"]) / truth["cell_size_m"]).astype(int)
    inside = (ix >= 0) & (ix < truth["nx"]) & (iy >= 0) & (iy < truth["ny"])
    return np.where(inside, iy, -1), np.where(inside, ix, -1)


def read(folder, name, at):
    cells = np.load(folder / "truth" / "cells" / f"{name}.npz")
    inside = at[0] >= 0
    state = np.where(inside, cells["state"][at], 0)
    speed = np.hypot(*cells["velocity"])
    return state, inside & (cells["occupied"][at] > 0) & (speed[at] > 0.3)


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


def print_rows(run, data):
    run_grid = json.loads((run / "run.json").read_text())["grid"]
    frames = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    by_stamp = {round(frame["stamp_ns"] / 1e7): frame for frame in frames}
    truth = truth_grid(data)
    pooled = {}
    for frame in frames:
        now = np.load(run / "grids" / f"{frame['name']}.npz")["occupancy"]
        ahead = np.load(run / "predictions" / f"{frame['name']}.npz")
        for horizon_s, predicted in zip(ahead["horizon_s"], ahead["occupancy"]):
            then = by_stamp.get(round(frame["stamp_ns"] / 1e7 + horizon_s * 100))
            if then is None:
                continue
            at = cells_then(run_grid, pose_of(frame), pose_of(then), truth)
            state, moving = read(data, then["name"], at)
            here = cells_then(run_grid, pose_of(frame), pose_of(frame), truth)
            moving |= read(data, frame["name"], here)[1]
            seen = state > 0
            pooled.setdefault(horizon_s, []).append(
                (predicted[seen], now[seen], state[seen] == 2, moving[seen]))
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
    tool, *inputs = sys.argv[1:]
    print("| sequence | s | cells | log-loss predicted / standing | AUC | moving: cells | log-loss | AUC |")
    print("|" + "---|" * 8)
    for data in map(pathlib.Path, inputs):
        with tempfile.TemporaryDirectory() as folder:
            run = pathlib.Path(folder) / "run"
            subprocess.run([tool, "-q", "run", data, "--out", run, "--predict", "0.5,1,2"], check=True, stdout=subprocess.DEVNULL)
            print_rows(run, data)


if __name__ == "__main__":
    main()
