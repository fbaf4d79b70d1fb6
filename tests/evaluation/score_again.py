#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tool on the lidar drives, lets it evaluate the runs, and works the scores out again from the runs' grids and
the drives' own files, by docs/evaluation.md: score_again.py TOOL"""
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

DRIVES = ("kitti_odo04", "kitti_raw0009")
BANDS = ((3, 10), (10, 20), (20, 30), (3, 20))
CAMERA_HEIGHT_M = 1.64
MARGIN_M = 0.5  # by which an obstacle is nearer than what it hides


def calibration(path):
    lines = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    left, lidar = (np.array(lines[key].split(), float).reshape(3, 4) for key in ("P0", "Tr"))
    return {"f": left[0, 0], "u0": left[0, 2], "lidar": lidar}


def heights_over_road(right, down, ahead):
    near = (ahead > 4) & (ahead < 30) & (np.abs(right) < 8)
    chosen = near & (np.abs(CAMERA_HEIGHT_M - down) < 0.35)
    basis = np.stack([right, ahead, np.ones_like(right)], 1)
    for _ in range(3):
        plane = np.linalg.lstsq(basis[chosen], down[chosen], rcond=None)[0]
        height = basis @ plane - down
        chosen = near & (np.abs(height) < 0.12)
    return height


def nearest_by_column(columns, ahead, width):
    nearest = np.full(width, np.inf)
    for u, z in zip(columns, ahead):
        covered = slice(max(int(np.ceil(u - 1.5)), 0), int(np.floor(u + 1.5)) + 1)
        nearest[covered] = np.minimum(nearest[covered], z)
    return nearest


def hidden_cells(label, nearest, grid, cal, width):
    hidden = np.zeros(label.shape, bool)
    size = grid["cell_size_m"]
    for iy, ix in zip(*np.nonzero(label >= 0)):
        x = grid["x_min_m"] + ix * size
        y = grid["y_min_m"] + iy * size
        if x <= MARGIN_M:
            continue
        corners = [cal["u0"] - cal["f"] * (y + j * size) / (x + i * size) for i in (0, 1) for j in (0, 1)]
        first, last = max(int(np.floor(min(corners) + 0.5)), 0), min(int(np.floor(max(corners) + 0.5)), width - 1)
        hidden[iy, ix] = first <= last and (nearest[first:last + 1] < x - MARGIN_M).all()
    return hidden


def labels(scan, grid, cal, width):
    right, down, ahead = cal["lidar"][:, :3] @ scan.T + cal["lidar"][:, 3:]
    height = heights_over_road(right, down, ahead)
    column = cal["u0"] + cal["f"] * right / ahead
    seen = (ahead > 1) & (column > 0) & (column < width)
    ix = np.floor((ahead - grid["x_min_m"]) / grid["cell_size_m"])
    iy = np.floor((-right - grid["y_min_m"]) / grid["cell_size_m"])
    inside = seen & (ix >= 0) & (ix < grid["nx"]) & (iy >= 0) & (iy < grid["ny"])

    def count(which):
        flat = (iy[which] * grid["nx"] + ix[which]).astype(int)
        return np.bincount(flat, minlength=grid["nx"] * grid["ny"]).reshape(grid["ny"], grid["nx"])

    upright = (height > 0.3) & (height < 1.8)
    obstacles, road = count(inside & upright), count(inside & (np.abs(height) < 0.12))
    label = np.where(obstacles >= 2, 1, np.where((obstacles == 0) & (road > 0), 0, -1))
    hiding = inside & upright & (ahead >= 3)
    hiding[hiding] = label[iy[hiding].astype(int), ix[hiding].astype(int)] == 1
    nearest = nearest_by_column(column[hiding], ahead[hiding], width)
    return label, hidden_cells(label, nearest, grid, cal, width)


def free_space_ends(occupied, grid, cal, width):
    """Near edge of the first occupied cell along each image column from 3 m on; inf: none."""
    size = grid["cell_size_m"]
    ends = np.full(width, np.inf)
    slopes = (cal["u0"] - np.arange(width)) / cal["f"]
    for ix in reversed(range(int(round((3 - grid["x_min_m"]) / size)), grid["nx"])):
        x = grid["x_min_m"] + ix * size
        rows = np.sort([np.floor((slopes * z - grid["y_min_m"]) / size) for z in (x, x + size)], axis=0).astype(int)
        first, last = (np.clip(row, 0, grid["ny"]) for row in (rows[0], rows[1] + 1))
        so_far = np.concatenate([[0], np.cumsum(occupied[:, ix])])
        ends[so_far[last] > so_far[first]] = x
    return ends


def recall_at(rate, positives, negatives):
    """Linear between the corners of the characteristic."""
    values = np.unique(np.concatenate([positives, negatives]))[::-1]
    alarms = np.array([0] + [(negatives >= v).mean() for v in values])
    found = np.array([0] + [(positives >= v).mean() for v in values])
    at = np.searchsorted(alarms, rate, side="right")  # the last corner at or left of the rate is at − 1
    if at == len(alarms):
        return found[-1]
    part = (rate - alarms[at - 1]) / (alarms[at] - alarms[at - 1])
    return found[at - 1] + part * (found[at] - found[at - 1])


def cell_scores(p, occupied, hidden):
    p = np.clip(p.astype(float), 0.001, 0.999)
    yes, no = p[occupied], p[~occupied]
    ordered = np.sort(no)
    wins = (np.searchsorted(ordered, yes, "left") + np.searchsorted(ordered, yes, "right")) / 2
    bins = np.minimum(np.floor(p * 15), 14)
    gaps = [abs(p[bins == b].sum() - occupied[bins == b].sum()) for b in range(15)]
    return {
        "cells": len(p), "occupied": len(yes), "hidden_occupied": (hidden & occupied).sum(),
        "hidden_free": (hidden & ~occupied).sum(),
        "balanced_log_loss": -(np.log(yes).mean() + np.log1p(-no).mean()) / 2,
        "brier": ((p - occupied) ** 2).mean(), "auc": wins.sum() / len(yes) / len(no),
        "iou_occupied": (yes > 0.55).sum() / (len(yes) + (no > 0.55).sum()),
        "iou_free": (no < 0.45).sum() / (len(no) + (yes < 0.45).sum()), "missed": (yes < 0.45).mean(),
        "false_alarms": (no > 0.55).mean(), "known": (np.abs(p - 0.5) > 0.05).mean(),
        "calibration_error": sum(gaps) / len(p), "hidden_recall": recall_at(0.01, p[occupied & hidden], no),
        "hidden_missed": (p[occupied & hidden] < 0.45).mean(),
    }


def depth_scores(truth, found, band):
    chosen = (truth >= band[0] - 1e-5) & (truth < band[1] - 1e-5)
    error, truth = (found - truth)[chosen], truth[chosen]
    wrong = np.abs(error) > 0.1 * truth + 1 + 1e-4
    return {"columns": len(error), "depth_error_m": np.abs(error).mean(), "depth_bias_m": error.mean(),
            "depth_wrong": wrong.mean(), "depth_overshoot": (wrong & (error > 0)).mean()}


def scores(run, drive):
    """(layer, band, scores) of all of them."""
    about = json.loads((run / "run.json").read_text())
    grid, width = about["grid"], about["rig"]["width_px"]
    cal = calibration(drive / "calib.txt")
    layers = {"observed": [], "occupancy": []}
    for file in sorted((drive / "velodyne").glob("*.bin")):
        if not (run / "grids" / f"{file.stem}.npz").exists():
            continue
        label, hidden = labels(np.fromfile(file, np.float32).reshape(-1, 4)[:, :3].astype(float), grid, cal, width)
        truth = free_space_ends(label == 1, grid, cal, width)
        for layer, frames in layers.items():
            p = np.load(run / "grids" / f"{file.stem}.npz")[layer]
            found = free_space_ends(p > 0.5, grid, cal, width)
            found[np.isinf(found)] = grid["x_min_m"] + grid["nx"] * grid["cell_size_m"]
            frames.append((p, label, hidden, truth, found))
    centres = grid["x_min_m"] + (np.arange(grid["nx"]) + 0.5) * grid["cell_size_m"]
    for layer, frames in layers.items():
        p, label, hidden, truth, found = (np.stack(part) for part in zip(*frames))
        for band in BANDS:
            scored = (label >= 0) & (centres >= band[0]) & (centres < band[1])
            yield layer, band, {**cell_scores(p[scored], label[scored] == 1, hidden[scored]),
                                **depth_scores(truth.ravel(), found.ravel(), band)}


def differences(said, again, where):
    for name, value in again.items():
        exact = isinstance(said[name], int)
        tool = said[name] if exact else said[name]["value"]
        if abs(tool - value) > (0 if exact else 5e-5):
            yield f"{where} {name}: the tool says {tool}, NumPy {value}"


def main():
    tool = sys.argv[1]
    data = Path(os.environ.get("STEREOGRID_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data")
    if not all((data / drive / "velodyne").is_dir() for drive in DRIVES):
        print("skipped: no data sets on this machine (STEREOGRID_DATA)")
        sys.exit(77)
    wrong, compared = [], 0
    for drive in DRIVES:
        with tempfile.TemporaryDirectory() as folder:
            run = Path(folder) / "run"
            mounted = Path(folder) / "calibration.yaml"  # labels here are of a level camera
            mounted.write_text(f"from: {data / drive / 'calib.txt'}\nmount: {{camera_height_m: {CAMERA_HEIGHT_M}}}\n")
            subprocess.run([tool, "--quiet", "run", data / drive, "--calibration", mounted, "--out", run, "--frames", ":20",
                            "--set", "grid.length_m=30", "--set", "matching.disparities=128"], check=True)
            subprocess.run([tool, "--quiet", "evaluate", run, "--json", Path(folder) / "scores.json"], check=True,
                           stdout=subprocess.DEVNULL)
            said = json.loads((Path(folder) / "scores.json").read_text())["series"]
            for layer, band, again in scores(run, data / drive):
                key = f"{band[0]}-{band[1]}"
                wrong += differences(said[layer]["bands"][key], again, f"{drive} {layer} {key} m")
                compared += len(again)
    print("\n".join(wrong))
    print(f"{compared} figures compared, {len(wrong)} differ")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
