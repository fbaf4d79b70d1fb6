#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the tool with preset `paper` and --save-stages, and works the saved u-disparity images and the observed grid out
again from the saved disparities, the rig and the ground: paper_again.py TOOL INPUT"""
import json
import math
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: NumPy is not installed")
    sys.exit(77)

HEIGHT, P_FP, P_FN, TAU, SIGMA_U, SIGMA_D = 1.8, 0.02, 0.02, 0.1, 1.5, 0.5


def counts(stages, rig, ground):
    """N_P, N_V, N_O and whether a bin holds road pixels (eq. 9 to 12)."""
    obstacle = np.rint(stages["obstacle_disparity"]).astype(int)
    road = np.rint(stages["road_disparity"]).astype(int)
    bins, (rows, columns) = len(stages["possible"]), obstacle.shape
    horizon = rig["cy_px"] - rig["focal_px"] * math.tan(ground["pitch_rad"])
    slope = 1 / (rig["baseline_m"] * math.cos(ground["pitch_rad"]))
    possible, visible, observed, has_road = [], *(np.zeros((bins, columns), int) for _ in range(3))
    for d in range(bins):
        first = max(math.ceil(horizon + d * (ground["height_m"] - HEIGHT) * slope), 0)
        last = min(math.floor(horizon + d * ground["height_m"] * slope), rows - 1)
        inside = obstacle[first:last + 1]
        possible.append(max(last - first + 1, 0))
        visible[d] = ((inside > 0) & (inside <= d)).sum(0)
        observed[d] = ((inside > 0) & (inside == d)).sum(0)
        has_road[d] = d > 0 and (road == d).any(0)
    return np.array(possible), visible, observed, has_road


def probabilities(possible, visible, observed, has_road):
    """P(V), P(C), P(R), P(T) (eq. 8, 11 to 15)."""
    bins, columns = visible.shape
    p_visible = np.where(possible[:, None] > 0, visible / np.maximum(possible, 1)[:, None], 0)
    share = np.where(visible > 0, observed / np.maximum(visible, 1), 0)
    confidence = 1 - np.exp(-share / TAU)
    obstacle = p_visible * (confidence * (1 - P_FP) + (1 - confidence) * P_FN) + (1 - p_visible) / 2
    padded = np.pad(has_road, 1)
    around = sum(padded[i:i + bins, j:j + columns] for i in range(3) for j in range(3)) / 9
    road = np.exp(-(1 - around) / TAU) * np.exp(-share / TAU)
    occupancy = np.clip(obstacle * (1 - road), P_FN, 1 - P_FP)
    occupancy[0] = 0.5
    return p_visible, confidence, road, occupancy


def smoothed(occupancy):
    def gaussian(sigma):
        below = lambda x: 0.5 * (1 + math.erf(x / sigma / math.sqrt(2)))
        reach = math.ceil(3 * sigma)
        weights = np.array([below(k + 0.5) - below(k - 0.5) for k in range(-reach, reach + 1)])
        return weights / weights.sum()

    def along(axis, image, weights):
        reach = len(weights) // 2
        padded = np.pad(image, [(reach, reach) if a == axis else (0, 0) for a in (0, 1)], "edge")
        return sum(w * np.take(padded, range(k, k + image.shape[axis]), axis) for k, w in enumerate(weights))

    return np.vstack([occupancy[:1], along(0, along(1, occupancy[1:], gaussian(SIGMA_U)), gaussian(SIGMA_D))])


def cell(occupancy, rig, x, y, size):
    """Largest occupancy of the bins whose footprint shares an area with a cell (eq. 16)."""
    focal_baseline, best = rig["focal_px"] * rig["baseline_m"], []
    for d in range(1, len(occupancy)):
        near, far = max(x, focal_baseline / (d + 0.5)), min(x + size, focal_baseline / (d - 0.5))
        if near >= far:
            continue
        seen = [rig["cx_px"] - rig["focal_px"] * yy / xx for xx in (near, far) for yy in (y, y + size)]
        columns = np.arange(occupancy.shape[1])
        touched = (columns + 0.5 > min(seen)) & (columns - 0.5 < max(seen))
        best += list(occupancy[d][touched])
    return max(best, default=0.5)


def check(name, got, expected, tolerance):
    worst = float(np.abs(np.asarray(got, float) - expected).max())
    print(f"{name}: largest difference {worst:.2g}")
    if not worst <= tolerance:
        sys.exit(f"{name} differs from its definition by {worst} (allowed: {tolerance})")


def main():
    tool, given = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([tool, "run", given, "--out", folder, "--preset", "paper", "--frames", "0:1", "--save-stages"],
                       check=True)
        run = json.load(open(f"{folder}/run.json"))
        frame = [json.loads(line) for line in open(f"{folder}/frames.jsonl")][1]
        stages = dict(np.load(f"{folder}/stages/{frame['name']}.npz"))
        observed_grid = np.load(f"{folder}/grids/{frame['name']}.npz")["observed"]
    rig, grid = run["level_rig"], run["grid"]
    numbers = counts(stages, rig, frame["ground"])
    for name, expected in zip(("possible", "visible", "observed_pixels"), numbers):
        check(name, stages[name], expected, 0)
    results = probabilities(*numbers)
    for name, expected in zip(("visibility", "obstacle_confidence", "road_confidence", "u_occupancy"), results):
        check(name, stages[name], expected, 1e-5)
    smooth = smoothed(results[-1])
    check("u_occupancy_smooth", stages["u_occupancy_smooth"], smooth, 1e-5)
    dice = np.random.default_rng(1)
    cells = [(dice.integers(5, grid["nx"]), dice.integers(0, grid["ny"])) for _ in range(300)]
    size = grid["cell_size_m"]
    expected = [cell(smooth, rig, grid["x_min_m"] + ix * size, grid["y_min_m"] + iy * size, size) for ix, iy in cells]
    check("observed", [observed_grid[iy, ix] for ix, iy in cells], expected, 1e-4)


if __name__ == "__main__":
    main()
