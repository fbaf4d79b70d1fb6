#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the paper's figures (docs/paper.md) of a drive or a built-in scene, from runs that it makes.

figures.py path/to/drive --frames 0:20 --out figures     the last frame is the one that is shown
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

BUILT = Path(__file__).resolve().parents[2] / "build" / "release"
sys.path.append(str(BUILT / "python"))  # the package in the build tree
try:
    import matplotlib
    import numpy as np
    import stereogrid  # noqa: F401
    from matplotlib.figure import Figure
except ModuleNotFoundError as missing:
    sys.exit(f"Python has no {missing.name}. Install python3-matplotlib and the package (docs/python.md).")

import panels
from run_folder import Fault, Run

SCENE, FRAMES = "scene:street?frames=45", "2:22"  # a person steps out from behind a parked car
# runs beside the first one, and their settings: without the Gaussian, and with one of the paper's error rates raised
VARIANTS = {"without_gaussian": ("paper.sigma_disparity=0", "paper.sigma_column=0"),
            "false_positive": ("paper.false_positive=0.25",), "false_negative": ("paper.false_negative=0.25",)}
BASELINES = ("nearest_obstacle_paper", "nearest_obstacle", "lidar")
MOMENTS, MOMENT_STEP = 3, 8  # moments of figure 7
STYLE = {"figure.facecolor": panels.PAPER, "axes.titlelocation": "left", "axes.titlesize": "medium",
         "text.color": panels.INK, "savefig.dpi": 100, "figure.constrained_layout.w_pad": 0.15,
         "figure.constrained_layout.h_pad": 0.1}


def sheet(title, lines, width, height):
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle("\n".join((title, *lines)), x=0.01, ha="left", fontsize="large")
    return figure


def source_line(run):
    return f"{run.drive.name}, frame {run.name}."


def filter_line(run):
    return f"Filtered: after {len(run.names) - 1} earlier frames, filter.model = {run.config['filter']['model']}."


def figure_1(config):
    def probability(visibility, share):
        confidence = panels.obstacle_confidence(share, config["tau_obstacle"])
        return panels.obstacle_probability(visibility, confidence, config)

    figure = sheet("Figure 1. Obstacle probability P(O), eqs. 8 and 13", [
        f"P_FP = {config['false_positive']:g}, P_FN = {config['false_negative']:g}, tau_O = {config['tau_obstacle']:g}. "
        "r_O = N_O / N_V: filled share of the visible rays."], 11, 5)
    labels = ("visibility P(V)", "obstacle share r_O", "P(O)")
    panels.surface(figure.add_subplot(121, projection="3d"), probability, (0, 1), (0, 1), labels, "(a) as a surface")
    panels.contours(figure.add_subplot(122), probability, (0, 1), (0, 1), labels, "(b) as a map, a line at every tenth")
    return figure


def figure_2(config):
    figure = sheet("Figure 2. Confidences and what they make of the occupancy", [
        f"tau_O = {config['tau_obstacle']:g}, tau_R = {config['tau_road']:g}. r_O: filled share of the visible rays. "
        "r_R: share of the nine bins around that hold road."], 11, 9.5)
    curves = figure.add_subplot(221)
    share = np.linspace(0, 1, 501)
    for factor, colour in ((0.5, "#21918c"), (1, "#440154"), (2, "#c87814")):
        tau = factor * config["tau_obstacle"]
        curves.plot(share, panels.obstacle_confidence(share, tau), color=colour,
                    label=f"tau_O = {tau:g}{', as set' if factor == 1 else ''}")
    curves.set(title="(a) obstacle confidence, eq. 13", xlabel="r_O = N_O / N_V", ylabel="P(C)", xlim=(0, 1), ylim=(0, 1))
    curves.grid(color="#e1e2e4")
    curves.legend()

    def road(observed, around):
        return panels.road_confidence(observed, around, config)

    labels = ("obstacle share r_O", "road share r_R", "P(R)")
    panels.contours(figure.add_subplot(222), road, (0, 0.3), (0.5, 1), labels, "(b) road confidence P(R), eq. 15")
    panels.surface(figure.add_subplot(223, projection="3d"), road, (0, 0.3), (0.5, 1), labels,
                   "(c) road confidence P(R) as a surface")
    panels.contours(figure.add_subplot(224), lambda o, r: panels.occupancy(o, r, config), (0, 1), (0, 1),
                    ("P(O)", "P(R)", "P(T)"), "(d) occupancy P(T), eq. 14")
    return figure


def figure_3(run):
    stages, observed = run.stages(), run.grids()["observed"]
    figure = sheet("Figure 3. From the image to the grid", [source_line(run)], 14, 14.5)
    axes = figure.subplots(4, 2, gridspec_kw={"height_ratios": (1.3, 1, 1, 1.8)}).ravel()
    road = panels.road_counts(stages["road_disparity"], len(stages["u_occupancy"]), run.disparities)
    panels.camera(axes[0], run.left_image(), "(a) left image")
    panels.counts(axes[1], stages["observed_pixels"], run, "(b) obstacle pixels N_O")
    panels.counts(axes[2], road, run, "(c) road pixels")
    panels.probabilities(axes[3], stages["visibility"], run, "(d) visibility P(V)", "P(V)")
    panels.probabilities(axes[4], stages["obstacle_confidence"], run, "(e) obstacle confidence P(C)", "P(C)")
    panels.probabilities(axes[5], stages["road_confidence"], run, "(f) road confidence P(R)", "P(R)")
    panels.occupancies(axes[6], stages["u_occupancy_smooth"], run, "(g) occupancy P(T), after the Gaussian")
    panels.grid(axes[7], observed, run, "(g) the same on the ground")
    return figure


def figure_4(run, without_gaussian):
    stages, grids = run.stages(), run.grids()
    config = run.bins
    figure = sheet("Figure 4. What the Gaussian and the temporal filter do", [
        f"{source_line(run)} Gaussian: {config['sigma_disparity']:g} px along disparity, "
        f"{config['sigma_column']:g} px along columns.", filter_line(run)], 14, 8)
    above, below = figure.subfigures(2, 1, height_ratios=(1, 1.2))
    left, right = above.subplots(1, 2)
    panels.occupancies(left, stages["u_occupancy"], run, "(a) P(T) as computed")
    panels.occupancies(right, stages["u_occupancy_smooth"], run, "(b) after the Gaussian")
    axes = below.subplots(1, 3)
    panels.grid(axes[0], without_gaussian.grids()["observed"], run, "(c) frame alone, no Gaussian")
    panels.grid(axes[1], grids["observed"], run, "(d) frame alone, with it")
    panels.grid(axes[2], grids["occupancy"], run, "(e) filtered")
    return figure


def figure_6(run, compared):
    figure = sheet("Figure 6. Beside the grid of nearest obstacles", [
        source_line(run) + " Lines: what the camera can see, and its distance."], 18, 11)
    above, below = figure.subfigures(2, 1, height_ratios=(1.2, 1))
    left, right = above.subplots(1, 2)
    panels.camera(left, run.left_image(), "(a) left image")
    panels.disparities(right, run.stages(), run, "(b) disparity")
    axes = below.subplots(1, 4)
    panels.grid(axes[0], compared["nearest_obstacle_paper"]["observed"], run, "(c) nearest obstacle, as in the paper")
    panels.grid(axes[1], run.grids()["observed"], run, "(d) visibility-based, frame alone")
    panels.grid(axes[2], compared["nearest_obstacle"]["observed"], run, "(e) nearest obstacle, tuned")
    if (known := run.truth()) is not None:
        panels.truth(axes[3], known, run, "what is there")
    elif "lidar" in compared:
        panels.scan(axes[3], run.in_vehicle(compared["lidar"]["sweep"]), run, "lidar, from above")
    else:
        axes[3].set_axis_off()
    return figure


def figure_7(run):
    moments = run.names[::-MOMENT_STEP][:MOMENTS]
    height_m = run.bins["obstacle_height_m"]
    figure = sheet("Figure 7. The result on the camera image", [
        f"{run.drive.name}. Image and u-disparity grid: P(T) before the Gaussian; slabs are {height_m:g} m high.",
        f"Filtered: from frame {run.names[0]} on, filter.model = {run.config['filter']['model']}."],
                   15, 1 + 3.5 * len(moments))
    axes = figure.subplots(len(moments), 3, squeeze=False, gridspec_kw={"width_ratios": (1.3, 1.1, 1)})
    for letter, name, (left, middle, right) in zip("abc", moments, axes):
        occupancy = run.stages(name)["u_occupancy"]
        picture = panels.overlaid(run.left_image(name), occupancy, run, run.grounds[name])
        panels.camera(left, picture, f"({letter}) frame {name}")
        panels.occupancies(middle, occupancy, run, "u-disparity grid")
        panels.grid(right, run.grids(name)["occupancy"], run, "filtered")
    panels.legend_below(axes[-1][0], ((panels.UPRIGHT, "upright, P(T) > 0.75"), (panels.ROAD, "road, P(T) < 0.4")))
    return figure


def figure_8(run, rates):
    runs = [run, *rates]
    figure = sheet("Figure 8. Influence of P_FP and P_FN", [source_line(run), filter_line(run)],
                   4.6 * len(runs), 8.5)
    for (layer, text), row in zip((("observed", "frame alone"), ("occupancy", "filtered")),
                                  figure.subplots(2, len(runs), squeeze=False)):
        for other, axes in zip(runs, row):
            config = other.bins
            rated = f"P_FP = {config['false_positive']:g}, P_FN = {config['false_negative']:g}"
            panels.grid(axes, other.grids()[layer], run, f"{text}, {rated}")
    return figure


def figure_9(run, compared):
    grids = run.grids()
    figure = sheet("Figure 9. Beside the lidar", [source_line(run)], 16, 6)
    axes = figure.subplots(1, 3)
    panels.grid(axes[0], grids["observed"], run, "(a) frame alone")
    panels.grid(axes[1], grids["occupancy"], run, "(b) filtered")
    points = run.in_vehicle(compared["lidar"]["sweep"])
    panels.scan(axes[2], points, run, "(c) lidar, from above")
    return figure


def draw(work):
    """The figures by their number, of the runs in the folder `work`; the ninth needs a lidar sweep."""
    run = Run(work / "run")
    without_gaussian, *rates = (Run(work / name) for name in VARIANTS)
    compared = {folder.name: np.load(file) for folder in (work / "compared").iterdir()
                if (file := folder / "grids" / f"{run.name}.npz").is_file()}
    with matplotlib.rc_context(STYLE):
        figures = {1: figure_1(run.bins), 2: figure_2(run.bins), 3: figure_3(run), 4: figure_4(run, without_gaussian),
                   6: figure_6(run, compared), 7: figure_7(run), 8: figure_8(run, rates)}
        if "lidar" in compared:
            figures[9] = figure_9(run, compared)
    return figures


def save(figures, out):
    try:
        Path(out).mkdir(parents=True, exist_ok=True)
        with matplotlib.rc_context(STYLE):
            for number, figure in sorted(figures.items()):
                figure.savefig(Path(out) / f"figure_{number}.png")
    except OSError as error:
        raise Fault(f"{out}: cannot be written ({error.strerror}).") from error


def settings(values):
    return [word for value in values for word in ("--set", value)]


def make_runs(source, work, programs, options):
    """Leaves the runs in the folder `work`."""
    tool = programs / "stereogrid"

    def run(program, *words):
        return subprocess.run([program, *words], stdout=subprocess.DEVNULL, check=True)

    run(tool, "run", "--quiet", source, "--out", work / "run", "--save-stages", *options)
    for name, changed in VARIANTS.items():
        run(tool, "run", "--quiet", source, "--out", work / name, *options, *settings(changed))
    run(programs / "stereogrid-baselines", work / "run", work / "compared", *BASELINES)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", nargs="?", help=f"a drive's folder, or a built-in scene (default: {SCENE}, {FRAMES})")
    parser.add_argument("--out", required=True, help="folder for figure_1.png and so on")
    parser.add_argument("--frames", metavar="FIRST:LAST", help="as of `stereogrid run`; the last one is shown")
    parser.add_argument("--preset", default="paper", help="default: paper")
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    parser.add_argument("--programs", type=Path, default=BUILT / "bin", metavar="DIR",
                        help="default: build/release/bin")
    arguments = parser.parse_args()
    for program in ("stereogrid", "stereogrid-baselines"):
        if not (arguments.programs / program).exists():
            sys.exit(f"{arguments.programs / program}: there is no such program. Build it: "
                     "cmake --build build/release --target stereogrid_tool stereogrid_baselines")
    options = ["--preset", arguments.preset, *settings(arguments.settings)]
    frames = arguments.frames or (None if arguments.input else FRAMES)
    options += ["--frames", frames] if frames else []
    with tempfile.TemporaryDirectory() as work:
        try:
            make_runs(arguments.input or SCENE, Path(work), arguments.programs, options)
            save(draw(Path(work)), arguments.out)
        except subprocess.CalledProcessError as error:  # the program has printed its message
            sys.exit(error.returncode)
        except Fault as fault:
            sys.exit(f"figures.py: {fault}")
    print(f"figures in {arguments.out}")


if __name__ == "__main__":
    main()
