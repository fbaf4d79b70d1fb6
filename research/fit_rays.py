#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits the weights of the ray model (docs/method.md, section 6.2) to labelled frames.

fit_rays.py RUN=DATA... [--header src/observation/rays/weights.hpp] [--to METRES]

RUN is a folder of `stereogrid run DATA --save-stages`, DATA the input with a Velodyne sweep (KITTI odometry layout) or
exact truth (truth/cells) for the same frames. Occupied and free cells weigh the same, a rendered sequence a third as
much as a drive. Prints for each input how the weights fitted on all the others score there, then writes the header with
those of all.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np

BINS_PER_PX = 2
COLUMNS_AROUND = 5
PIXEL_UNIT, RAY_UNIT, HALF_KNOWN_RAYS = 0.3, 1.0, 0.5
WEAK_LOG_ODDS = 3.0
NAMES = ("ending", "behind", "in_front", "road_in_front", "arriving", "passing", "passing_farther")
UNITS = np.array([PIXEL_UNIT] * 4 + [RAY_UNIT] * 3)


def sums_of(counts: np.ndarray) -> np.ndarray:
    """(bins + 1, width + 1): of all bins before k and all columns before u."""
    return np.pad(counts.cumsum(0).cumsum(1), ((1, 0), (1, 0)))


def opaque_bins(ambiguous: np.ndarray, drop: np.ndarray, first: np.ndarray, bottom: float) -> int:
    """As opaque_bins() of src/observation/rays: bins of a column that a repeating pattern hides."""
    for v in np.flatnonzero(ambiguous)[::-1]:
        if not drop[v] > 0:
            break
        begin = np.searchsorted(drop, 2 * bottom * first[v] / BINS_PER_PX - drop[v])
        count = np.count_nonzero(ambiguous[begin:v + 1])
        if count >= 8 and 4 * count >= v + 1 - begin:
            return first[v + 6 if v + 6 < len(first) else v] + 1
    return 0


def count_rays(stages, frame: dict, rig: dict, heights: tuple) -> dict:
    """As count_rays() of src/rays."""
    obstacle, road = stages["obstacle_disparity"], stages["road_disparity"]
    rows, columns = obstacle.shape
    bins = stages["u_occupancy"].shape[0] * BINS_PER_PX
    ground = frame["ground"]
    shift = np.round(-np.tan(ground.get("roll_rad", 0)) * (np.arange(columns) - rig["cx_px"]))
    horizon = rig["cy_px"] - rig["focal_px"] * np.tan(ground["pitch_rad"])
    drop = (np.arange(rows)[:, None] - shift - horizon) * rig["baseline_m"] * np.cos(ground["pitch_rad"])
    height = ground["height_m"]
    top = height - heights[1]
    if top >= 0:
        sys.exit("The camera is higher than the highest obstacles: its frames cannot be used here.")
    first = np.where(drop > 0, drop / height, drop / top)
    disparity = np.where(obstacle > 0, obstacle, road)
    column = np.broadcast_to(np.arange(columns), obstacle.shape)

    def histogram(chosen, places):
        k = np.minimum((places[chosen] * BINS_PER_PX).astype(int), bins)
        return np.bincount(k * columns + column[chosen], minlength=(bins + 1) * columns).reshape(-1, columns)[:bins]

    arriving = np.pad(histogram(disparity > 0, np.maximum(disparity, first)).cumsum(0), ((1, 0), (0, 0)))
    ambiguous = stages["ambiguous"] != 0
    bin_of_road = np.minimum(first * BINS_PER_PX, bins).astype(int)
    for u in np.flatnonzero(np.count_nonzero(ambiguous, 0)):
        arriving[:opaque_bins(ambiguous[:, u], drop[:, u], bin_of_road[:, u], height - heights[0]), u] = 0
    upright = (obstacle > 0) & (drop >= top * obstacle) & (drop <= (height - heights[0]) * obstacle)
    return {"ending": sums_of(histogram(upright, obstacle)),
            "arriving": np.pad(arriving.cumsum(1), ((0, 0), (1, 0))),
            "road": sums_of(histogram((road > 0) & ~(obstacle > 0), road))}


def mean_before(sums: np.ndarray, disparity, begin, end):
    """Mean over the columns begin … end of the counts nearer to 0 than the disparity."""
    place = np.clip(disparity * BINS_PER_PX, 0, sums.shape[0] - 1)
    k = np.minimum(place.astype(int), sums.shape[0] - 2)
    part = place - k
    until = lambda u: (1 - part) * sums[k, u] + part * sums[k + 1, u]
    return (until(end) - until(begin)) / (end - begin)


def columns_of(rig: dict, grid: dict, ix, iy) -> tuple:
    """Borders between columns that a cell lies between, at least one apart; they may lie outside the image."""
    single = np.float32  # as CellPlaces of src/projection has it
    size = grid["cell_size_m"]
    x, y = (single(grid[low] + 0.5 * size) + single(size) * single(i) for low, i in (("x_min_m", ix), ("y_min_m", iy)))
    per_m = single(rig["focal_px"]) / x
    left, right = (np.floor(single(rig["cx_px"]) - per_m * (y + single(side * size / 2)) + single(1)).astype(int)
                   for side in (1, -1))
    return left, np.maximum(right, left + 1)


def in_view(rig: dict, grid: dict, disparities: int, ix, iy) -> np.ndarray:
    """A column at least, and not nearer than all disparities."""
    left, right = (np.clip(border, 0, rig["width_px"]) for border in columns_of(rig, grid, ix, iy))
    near = rig["focal_px"] * rig["baseline_m"] / (grid["x_min_m"] + ix * grid["cell_size_m"])
    return (right > left) & (near <= disparities - 1)


def blur_of(obstacle: np.ndarray, window_px: int) -> float:
    """As blur_of() of src/rays."""
    disparity, apart = obstacle[5:-5:6, 9:-8:6], max(window_px // 9, 1)
    before, here, after = disparity[:, :-2 * apart], disparity[:, apart:-apart], disparity[:, 2 * apart:]
    alike = (before > 0) & (here > 0) & (after > 0) & (abs(before - after) < 1.5)
    if alike.sum() < 100:
        return 0.5
    parts = np.sort((abs(before - 2 * here + after)[alike] * 64).astype(int))
    return float(np.clip(2.1 * (parts[(len(parts) - 1) // 2] + 0.5) / 64, 0.35, 0.5))


def features_of(sums: dict, rig: dict, grid: dict, ix, iy, blur: float) -> np.ndarray:
    """CellRays of src/rays, in the order of NAMES; of cells in view of the camera."""
    size = grid["cell_size_m"]
    x = grid["x_min_m"] + (ix + 0.5) * size
    width = sums["ending"].shape[1] - 1
    left, right = columns_of(rig, grid, ix, iy)
    near, far = (rig["focal_px"] * rig["baseline_m"] / (x + side * size / 2) for side in (-1, 1))
    within = lambda u: np.clip(u, 0, width)
    narrow = within(left), within(right)
    wide = within(left - COLUMNS_AROUND), within(right + COLUMNS_AROUND)
    between = lambda kind, a, b, part: mean_before(sums[kind], b, *part) - mean_before(sums[kind], a, *part)
    arriving = lambda disparity: mean_before(sums["arriving"], disparity, *narrow)
    return np.stack([between("ending", far - blur, near + blur, wide), between("ending", far - 4, far, narrow),
                     between("ending", near, near + 4, narrow), between("road", near, near + 1, narrow),
                     arriving(near), arriving(far), arriving(far - 1)], axis=1)


def inputs_of(features: np.ndarray) -> np.ndarray:
    """Features of the ray model."""
    arriving = np.maximum(features[:, 4:5], 0)
    return np.log1p(np.maximum(features, 0) / UNITS) * arriving / (arriving + HALF_KNOWN_RAYS)


def kitti_calibration(path: Path) -> np.ndarray:
    for line in path.read_text().splitlines():
        if line.startswith("Tr:"):
            return np.array(line.split()[1:], float).reshape(3, 4)
    sys.exit(f"{path}: no line Tr, from the lidar to the camera.")


def lidar_labels(points: np.ndarray, rig: dict, grid: dict) -> np.ndarray:
    """1 occupied, 0 free, −1 unknown: docs/evaluation.md. points: (N, 3) m, in the camera's frame."""
    x, y, z = points.T
    near = (z > 4) & (z < 30) & (abs(x) < 8)
    plane, within = np.array([0, 0, rig["camera_height_m"]]), 0.35
    for _ in range(4):
        chosen = near & (abs(y - x * plane[0] - z * plane[1] - plane[2]) < within)
        plane = np.linalg.lstsq(np.c_[x, z, np.ones_like(x)][chosen], y[chosen], rcond=None)[0]
        within = 0.12
    height = x * plane[0] + z * plane[1] + plane[2] - y
    u = rig["cx_px"] + rig["focal_px"] * x / np.maximum(z, 0.1)
    ix = np.floor((z - grid["x_min_m"]) / grid["cell_size_m"]).astype(int)
    iy = np.floor((-x - grid["y_min_m"]) / grid["cell_size_m"]).astype(int)
    seen = (z > 1) & (u > 0) & (u < rig["width_px"]) & (ix >= 0) & (ix < grid["nx"]) & (iy >= 0) & (iy < grid["ny"])
    obstacle, road = np.zeros((2, grid["ny"], grid["nx"]), int)
    np.add.at(obstacle, (iy[on := seen & (height > 0.3) & (height < 1.8)], ix[on]), 1)
    np.add.at(road, (iy[on := seen & (abs(height) < 0.12)], ix[on]), 1)
    return np.where(obstacle >= 2, 1, np.where((obstacle == 0) & (road > 0), 0, -1))


def truth_labels(data: Path, name: str, grid: dict) -> np.ndarray:
    of_truth = json.loads((data / "truth/grid.json").read_text())
    state = np.load(data / f"truth/cells/{name}.npz")["state"]
    labels = np.full((grid["ny"], grid["nx"]), -1)
    size = grid["cell_size_m"]
    if abs(of_truth["cell_size_m"] - size) > 1e-9:
        sys.exit(f"{data}: the truth has cells of {of_truth['cell_size_m']} m, the run of {size} m.")
    dx, dy = (round((of_truth[key] - grid[key]) / size) for key in ("x_min_m", "y_min_m"))
    for ty, row in enumerate(state):
        for tx, cell in enumerate(row):
            if cell and 0 <= ty + dy < grid["ny"] and 0 <= tx + dx < grid["nx"]:
                labels[ty + dy, tx + dx] = 1 if cell == 2 else 0
    return labels


def samples_of(run_folder: Path, data: Path, to_m: float, with_observed=False):
    """Inputs, labels and importance of all labelled cells from 3 m on; and the run's own probabilities."""
    run = json.loads((run_folder / "run.json").read_text())
    if run["config"]["ground"]["model"] != "plane":
        sys.exit(f"{run_folder}: rays are counted over the plane here: run with --set ground.model=plane.")
    camera, rig, grid = run["rig"], run["level_rig"], run["grid"]
    heights = tuple(run["config"]["u_disparity"][key] for key in ("obstacle_min_height_m", "obstacle_height_m"))
    matching = run["config"]["matching"]
    shows_errors = matching["subpixel"] and run["matcher"] == "own"
    is_lidar = (data / "velodyne").is_dir()
    if is_lidar and any(rig[key] != camera[key] for key in ("cy_px", "height_px")):
        sys.exit(f"{run_folder}: lidar labels need a camera that is level, within a degree.")
    to_camera = kitti_calibration(data / "calib.txt") if is_lidar else None
    features, labels, observed = [], [], []
    for line in (run_folder / "frames.jsonl").read_text().splitlines():
        frame = json.loads(line)
        sweep = data / "velodyne" / f"{frame['name']}.bin"
        if is_lidar and not sweep.exists():
            continue
        if is_lidar:
            points = np.fromfile(sweep, np.float32).reshape(-1, 4)[:, :3].astype(float)
            cells = lidar_labels(points @ to_camera[:, :3].T + to_camera[:, 3], rig, grid)
        else:
            cells = truth_labels(data, frame["name"], grid)
        near_m = grid["x_min_m"] + np.arange(grid["nx"]) * grid["cell_size_m"]
        cells[:, (near_m < 3 - 1e-6) | (near_m >= to_m - 1e-6)] = -1
        iy, ix = np.nonzero(cells >= 0)
        iy, ix = iy[seen := in_view(rig, grid, run["config"]["matching"]["disparities"], ix, iy)], ix[seen]
        with np.load(run_folder / "stages" / f"{frame['name']}.npz") as stages:
            blur = blur_of(stages["obstacle_disparity"], matching["window_px"]) if shows_errors else 0.5
            features.append(features_of(count_rays(stages, frame, rig, heights), rig, grid, ix, iy, blur))
        labels.append(cells[iy, ix])
        if with_observed:
            observed.append(np.load(run_folder / "grids" / f"{frame['name']}.npz")["observed"][iy, ix])
    if not labels:
        sys.exit(f"{run_folder}: no frame of it is labelled in {data}.")
    samples = inputs_of(np.concatenate(features)), np.concatenate(labels) == 1, 3.0 if is_lidar else 1.0
    return (*samples, np.concatenate(observed)) if with_observed else samples


def limited(log_odds: np.ndarray) -> tuple:
    """log_odds_of() of src/rays: the logarithm of the odds that a weighted sum stands for, and its derivative."""
    power, weak = log_odds ** 6, WEAK_LOG_ODDS ** 6
    share = power / (power + weak)
    against = log_odds < 0
    return np.where(against, log_odds * share, log_odds), np.where(against, share * (7 - 6 * share), 1)


def fit(samples: list) -> np.ndarray:
    """Weights of least logistic loss, with a little of their squares against exchange: steps of Gauss and Newton, halved
    where the loss would grow. It has more than one minimum: begins from that of the weighted sums as they are."""
    inputs = np.concatenate([s[0] for s in samples])
    occupied = np.concatenate([s[1] for s in samples])
    importance = np.concatenate([np.where(s[1], 0.5 / s[1].sum(), 0.5 / (~s[1]).sum()) * s[2] for s in samples])
    sign = np.where(occupied, -1, 1)

    def least(weights, model):
        loss = lambda w: (importance * np.logaddexp(0, sign * model(inputs @ w)[0])).sum() + 0.5e-4 * w @ w
        for _ in range(100):
            log_odds, slope = model(inputs @ weights)
            p = 1 / (1 + np.exp(-log_odds))
            gradient = inputs.T @ (importance * (p - occupied) * slope) + 1e-4 * weights
            curvature = (inputs * (importance * p * (1 - p) * slope ** 2)[:, None]).T @ inputs + 1e-4 * np.eye(len(weights))
            step = np.linalg.solve(curvature, gradient)
            before = loss(weights)
            while loss(weights - step) > before and abs(step).max() > 1e-6:
                step /= 2
            weights = weights - step
            if abs(step).max() < 1e-6:
                break
        return weights

    return least(least(np.zeros(inputs.shape[1]), lambda sums: (sums, 1)), limited)


def scores(weights: np.ndarray, inputs: np.ndarray, occupied: np.ndarray) -> tuple:
    """Balanced log-loss, area under the curve, missed."""
    p = np.clip(1 / (1 + np.exp(-limited(inputs @ weights)[0])), 0.001, 0.999)
    rank = np.empty(len(p))
    rank[np.argsort(p, kind="stable")] = np.arange(1, len(p) + 1)
    positives, negatives = occupied.sum(), (~occupied).sum()
    auc = (rank[occupied].sum() - positives * (positives + 1) / 2) / (positives * negatives)
    loss = -0.5 * (np.log(p[occupied]).mean() + np.log(1 - p[~occupied]).mean())
    return loss, auc, (p[occupied] < 0.45).mean()


def write_header(path: Path, weights: np.ndarray, names: list):
    lines = path.read_text().splitlines()
    begin = next(i for i, line in enumerate(lines) if line.startswith("/// Fitted"))
    end = next(i for i, line in enumerate(lines) if i > begin and line == "};")
    lines[begin:end] = [f"/// Fitted on {', '.join(names)}: the logarithm of the odds by each input.",
                        "struct RayWeights {",
                        "  float value[cell_rays]{" + ", ".join(f"{value:.3f}f" for value in weights) + "};"]
    path.write_text("\n".join(lines) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", metavar="RUN=DATA")
    parser.add_argument("--header", type=Path, help="the weights are written here")
    parser.add_argument("--to", type=float, default=20, metavar="METRES", help="cells farther ahead do not count")
    arguments = parser.parse_args()
    pairs = [tuple(map(Path, pair.split("=", 1))) for pair in arguments.pairs if "=" in pair]
    if len(pairs) < len(arguments.pairs) or len(pairs) < 2:
        parser.error("at least two RUN=DATA are needed")
    names = [data.name for _, data in pairs]
    samples = [samples_of(run, data, arguments.to) for run, data in pairs]
    print("| scored on | log-loss | AUC | missed | log-loss, fitted on it too |\n|---|---|---|---|---|")
    of_all = fit(samples)
    for i, (inputs, occupied, _) in enumerate(samples):
        left_out = scores(fit(samples[:i] + samples[i + 1:]), inputs, occupied)
        print(f"| {names[i]} | {left_out[0]:.3f} | {left_out[1]:.3f} | {left_out[2]:.3f} |"
              f" {scores(of_all, inputs, occupied)[0]:.3f} |")
    print("\n" + "\n".join(f"{name} {value:.3f}" for name, value in zip(NAMES, of_all)))
    if arguments.header:
        write_header(arguments.header, of_all, names)


if __name__ == "__main__":
    main()
