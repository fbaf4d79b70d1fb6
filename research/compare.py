#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores other methods beside this library's variants, all on the same disparities, and prints Markdown tables, which
scripts/measure.py keeps. The grids that scripts/score_runs.py scores are left out unless --only names them.

compare.py PROGRAMS INPUT... [--set KEY=VALUE ...]     PROGRAMS: folder of stereogrid and stereogrid-baselines

Other options of `stereogrid run`, as --NAME=VALUE, are passed to it.
"""
import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
from score_runs import GRIDS, LABELS, print_table, text_of  # noqa: E402

# methods in the order of the table: title, run (below the folder of all), series; those of OWN_RUNS are runs of the tool
METHODS = {
    "observed": ("visibility grid (this library)", "own", "observed"),
    "observed_paper": ("visibility grid as published", "paper", "observed"),
    "nearest_obstacle": ("nearest obstacle, ternary (2000)", "nearest_obstacle", "observed"),
    "nearest_obstacle_paper": ("nearest obstacle as in the paper", "nearest_obstacle_paper", "observed"),
    "occupancy_boundary": ("stochastic grid, dyn. programming (2007)", "occupancy_boundary", "observed"),
    "free_space": ("free space of stixels (2009)", "free_space", "observed"),
    "stixels": ("multi-layer stixels (2011)", "stixels", "observed"),
    "ray_casting": ("point cloud, ray casting", "ray_casting", "observed"),
    "fused": ("visibility grid, fused with lidar", "fused", "observed"),
    "lidar": ("lidar, inverse sensor model", "lidar", "observed"),
    "filter_joint": ("visibility grid, filter joint", "own", "occupancy"),
    "filter_tay2008": ("visibility grid, filter tay2008", "tay2008", "occupancy"),
    "filter_fused": ("fused with lidar, filtered", "fused", "occupancy"),
    "ray_casting_map": ("ray casting, log-odds over time", "ray_casting_map", "occupancy"),
}
NEED_LIDAR = {"fused", "lidar", "filter_fused"}
SCORED_ELSEWHERE = {"observed", "filter_joint"}


def own_runs(tool: Path) -> dict:
    """Options of the runs of this library."""
    listed = subprocess.run([tool, "config", "--preset", "paper"], check=True, capture_output=True, text=True).stdout
    paper = re.findall(r"^  ((?:u_disparity|paper|projection)\.\w+) = (\S+)", listed, re.MULTILINE)
    return {"own": ["--save-stages"], "paper": [f"--set={key}={value}" for key, value in paper],
            "tay2008": ["--set=filter.model=tay2008"], "fused": ["--fuse", "lidar"]}


def thinned(drive: Path, target: Path, even: bool) -> Path:
    """A copy of a drive with every second ring of its sweeps; a ring ends where the azimuth passes straight ahead."""
    import numpy as np

    for source in drive.rglob("*"):
        copy = target / source.relative_to(drive)
        if source.is_dir():
            copy.mkdir(parents=True, exist_ok=True)
        elif source.suffix != ".bin":
            copy.symlink_to(source.resolve())
        else:
            points = np.fromfile(source, np.float32).reshape(-1, 4)
            ahead, left = points[:, 0], points[:, 1]
            ends = (left[:-1] < 0) & (left[1:] >= 0) & (ahead[1:] > 0)
            ring = np.concatenate([[0], np.cumsum(ends)])
            points[ring % 2 == (0 if even else 1)].tofile(copy)
    return target


def made(programs: Path, source: str, folder: Path, options: list, names: list) -> None:
    """Makes the runs of the methods below `folder`."""
    runs = own_runs(programs / "stereogrid")
    needed = {METHODS[name][1] for name in names}
    for run in sorted((needed & runs.keys()) | {"own"}):
        subprocess.run([programs / "stereogrid", "run", "-q", source, "--out", folder / run, *options, *runs[run]],
                       check=True, stdout=subprocess.DEVNULL)
    if others := sorted(needed - runs.keys()):
        subprocess.run([programs / "stereogrid-baselines", folder / "own", folder, *others], check=True)


def scores(programs: Path, run: Path, labels: list) -> dict:
    result = run / "scores.json"
    subprocess.run([programs / "stereogrid", "evaluate", "-q", run, *labels, "--json", result], check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads(result.read_text(encoding="utf-8"))["series"]


def print_methods(title: str, series: dict) -> None:
    first = next(iter(series.values()))["bands"]["3-20"]
    title += (f" ({first['frames']} frames, {first['cells']} cells, {first['occupied']} occupied, "
              f"{first['hidden_occupied']} of them partly hidden)")
    rows, over_time = [], False
    for method, scored in series.items():
        if METHODS[method][2] == "occupancy" and not over_time:
            rows.append(["*over time*", *[""] * (len(GRIDS) + 1)])
        over_time = METHODS[method][2] == "occupancy"
        rows += [[f"`{method}`", labels, *(text_of(figures[key]["value"], 3) for key in GRIDS)]
                 for band, labels in LABELS.items() if (figures := scored["bands"].get(band))]
    print_table(title, ["method", "labels", *GRIDS.values()], rows)


def draw(source: str, folder: Path, names: list, target: Path) -> None:
    """Image of the last frame, and below it the truth and every method's grid from above. Red: seen obstacles behind
    nearer ones."""
    import matplotlib.pyplot as plt
    import numpy as np
    import stereogrid
    from matplotlib.colors import ListedColormap
    from stereogrid import plot

    run, recording = stereogrid.read_run(folder / "own"), stereogrid.open(source)
    frame = recording[run.frames[-1].index]
    figure = plt.figure(figsize=(15, 7.9), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(1.35, 1))
    image = above.subplots()
    image.imshow(frame.left, cmap="gray", vmin=0, vmax=255)
    image.set_axis_off()
    truth, *axes = below.subplots(1, len(names) + 1)
    state, grid = frame.truth.state, recording.truth_grid.grid
    x, y = plot.centers(grid)
    bearing = np.round(np.degrees(np.arctan2(y, x)) / 2).astype(int)  # as wide as a cell 6 m ahead
    nearest = np.full(361, np.inf)
    np.minimum.at(nearest, bearing[state == 2], x[state == 2])
    shown = np.where(state == 2, np.where(x > nearest[bearing] + 0.5, 3, 2), state)
    colors = [*(plot.COLORS[f"cell-{state}"] for state in ("unknown", "free", "occupied")), "#e62828"]
    plot.cells(grid, shown, truth, cmap=ListedColormap(colors), vmin=0, vmax=3)
    for name, one in zip(names, axes):
        title, place, series = METHODS[name]
        grids = stereogrid.read_run(folder / place).grids(run.frames[-1].name)
        plot.occupancies(run.grid, getattr(grids, series), one)
        one.set_title(title, loc="left", fontsize="medium")
    truth.set_title("truth", loc="left", fontsize="medium")
    for one in (truth, *axes):
        one.set(xticks=[], yticks=[], xlabel="", ylabel="")
    figure.savefig(target, dpi=100)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=Path)
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--only", default="", metavar="NAME,...", help=", ".join(METHODS))
    parser.add_argument("--hold-out", action="store_true", help="rings that are fused are not those of the labels")
    parser.add_argument("--figure", type=Path, metavar="FILE.png", help="draw the last frame's grids; needs exact truth")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    arguments, options = parser.parse_known_args()
    options += [f"--set={setting}" for setting in arguments.set]
    only = arguments.only.split(",") if arguments.only else []
    if unknown := set(only) - METHODS.keys():
        sys.exit(f"--only: unknown method {', '.join(sorted(unknown))} (allowed: {', '.join(METHODS)}).")
    for source in arguments.inputs:
        has_lidar = any(Path(source).rglob("*.bin"))
        names = only or [name for name in METHODS if name not in SCORED_ELSEWHERE and (has_lidar or name not in NEED_LIDAR)]
        with tempfile.TemporaryDirectory() as work:
            folder, labels, used = Path(work), [], source
            if arguments.hold_out:
                used = str(thinned(Path(source), folder / "even", even=True))
                labels = [thinned(Path(source), folder / "odd", even=False)]
            made(arguments.programs, used, folder, options, names)
            scored = {run: scores(arguments.programs, folder / run, labels) for run in {METHODS[name][1] for name in names}}
            print_methods(Path(source).name, {name: scored[METHODS[name][1]][METHODS[name][2]] for name in names})
            if arguments.figure:
                draw(source, folder, names, arguments.figure)


if __name__ == "__main__":
    main()
