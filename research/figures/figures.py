#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Draws the paper's figures (docs/paper.md) from what `stereogrid run --save-stages` left. make_figures.py makes all runs
that they need."""
import argparse
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure

import equations
import panels
from run_folder import Complaint, Run, in_vehicle

MOMENTS, MOMENT_STEP = 3, 8  # moments of figure 7
STYLE = {"figure.facecolor": panels.PAPER, "axes.titlelocation": "left", "axes.titlesize": "medium",
         "text.color": panels.INK, "savefig.dpi": 100, "figure.constrained_layout.w_pad": 0.15,
         "figure.constrained_layout.h_pad": 0.1}


def sheet(title, lines, width, height):
    figure = Figure(figsize=(width, height), layout="constrained")
    figure.suptitle("\n".join((title, *lines)), x=0.01, ha="left", fontsize="large")
    return figure


def bin_parameters(run):
    return {**run.config["u_disparity"], **run.config["paper"]}


def source_line(run, place):
    return f"{run.source}, frame {run.names[place]}."


def filter_line(run, place):
    return f"Filtered: after {place} earlier frames, filter.model = {run.config['filter']['model']}."


def figure_1(config):
    def probability(visibility, share):
        confidence = equations.obstacle_confidence(share, config["tau_obstacle"])
        return equations.obstacle_probability(visibility, confidence, config)

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
        curves.plot(share, equations.obstacle_confidence(share, tau), color=colour,
                    label=f"tau_O = {tau:g}{', as set' if factor == 1 else ''}")
    curves.set(title="(a) obstacle confidence, eq. 13", xlabel="r_O = N_O / N_V", ylabel="P(C)", xlim=(0, 1), ylim=(0, 1))
    curves.grid(color="#e1e2e4")
    curves.legend()

    def road(observed, around):
        return equations.road_confidence(observed, around, config)

    labels = ("obstacle share r_O", "road share r_R", "P(R)")
    panels.contours(figure.add_subplot(222), road, (0, 0.3), (0.5, 1), labels, "(b) road confidence P(R), eq. 15")
    panels.surface(figure.add_subplot(223, projection="3d"), road, (0, 0.3), (0.5, 1), labels,
                   "(c) road confidence P(R) as a surface")
    panels.contours(figure.add_subplot(224), lambda o, r: equations.occupancy(o, r, config), (0, 1), (0, 1),
                    ("P(O)", "P(R)", "P(T)"), "(d) occupancy P(T), eq. 14")
    return figure


def figure_3(run, place):
    name = run.names[place]
    stages, observed = run.arrays("stages", name), run.arrays("grids", name)["observed"]
    figure = sheet("Figure 3. From the image to the grid", [source_line(run, place)], 14, 14.5)
    axes = figure.subplots(4, 2, gridspec_kw={"height_ratios": (1.3, 1, 1, 1.8)}).ravel()
    road = equations.road_counts(stages["road_disparity"], len(stages["u_occupancy"]), run.disparities)
    panels.camera(axes[0], run.left_image(name), "(a) left image")
    panels.counts(axes[1], stages["observed_pixels"], run, "(b) obstacle pixels N_O")
    panels.counts(axes[2], road, run, "(c) road pixels")
    panels.probabilities(axes[3], stages["visibility"], run, "(d) visibility P(V)", "P(V)")
    panels.probabilities(axes[4], stages["obstacle_confidence"], run, "(e) obstacle confidence P(C)", "P(C)")
    panels.probabilities(axes[5], stages["road_confidence"], run, "(f) road confidence P(R)", "P(R)")
    panels.occupancies(axes[6], stages["u_occupancy_smooth"], run, "(g) occupancy P(T), after the Gaussian")
    panels.grid(axes[7], observed, run, "(g) the same on the ground")
    return figure


def figure_4(run, place, without_gaussian):
    name = run.names[place]
    stages, grids = run.arrays("stages", name), run.arrays("grids", name)
    config = bin_parameters(run)
    figure = sheet("Figure 4. What the Gaussian and the temporal filter do", [
        f"{source_line(run, place)} Gaussian: {config['sigma_disparity']:g} px along disparity, "
        f"{config['sigma_column']:g} px along columns.", filter_line(run, place)], 14, 8)
    above, below = figure.subfigures(2, 1, height_ratios=(1, 1.2))
    left, right = above.subplots(1, 2)
    panels.occupancies(left, stages["u_occupancy"], run, "(a) P(T) as computed")
    panels.occupancies(right, stages["u_occupancy_smooth"], run, "(b) after the Gaussian")
    axes = below.subplots(1, 3)
    panels.grid(axes[0], without_gaussian.arrays("grids", name)["observed"], run, "(c) frame alone, no Gaussian")
    panels.grid(axes[1], grids["observed"], run, "(d) frame alone, with it")
    panels.grid(axes[2], grids["occupancy"], run, "(e) filtered")
    return figure


def figure_6(run, place, compared):
    name = run.names[place]
    figure = sheet("Figure 6. Beside the grid of nearest obstacles", [
        source_line(run, place) + " Lines: what the camera can see, and its distance."], 18, 11)
    above, below = figure.subfigures(2, 1, height_ratios=(1.2, 1))
    left, right = above.subplots(1, 2)
    panels.camera(left, run.left_image(name), "(a) left image")
    panels.disparities(right, run.arrays("stages", name), run, "(b) disparity")
    axes = below.subplots(1, 4)
    panels.grid(axes[0], compared["nearest_obstacle_paper"], run, "(c) nearest obstacle, as in the paper")
    panels.grid(axes[1], run.arrays("grids", name)["observed"], run, "(d) visibility-based, frame alone")
    panels.grid(axes[2], compared["nearest_obstacle"], run, "(e) nearest obstacle, tuned")
    if (known := run.truth(name)) is not None:
        panels.truth(axes[3], known, run, "what is there")
    elif "sweep" in compared:
        panels.scan(axes[3], in_vehicle(compared["sweep"], run.rig, run.lines[place]["ground"]), run, "lidar, from above")
    else:
        axes[3].set_axis_off()
    return figure


def figure_7(run, place):
    places = [place - i * MOMENT_STEP for i in range(MOMENTS) if place >= i * MOMENT_STEP]
    height_m = bin_parameters(run)["obstacle_height_m"]
    figure = sheet("Figure 7. The result on the camera image", [
        f"{run.source}. Image and u-disparity grid: P(T) before the Gaussian; slabs are {height_m:g} m high.",
        f"Filtered: from frame {run.names[0]} on, filter.model = {run.config['filter']['model']}."],
                   15, 1 + 3.5 * len(places))
    axes = figure.subplots(len(places), 3, squeeze=False, gridspec_kw={"width_ratios": (1.3, 1.1, 1)})
    for letter, moment, (left, middle, right) in zip("abc", places, axes):
        name = run.names[moment]
        occupancy = run.arrays("stages", name)["u_occupancy"]
        picture = panels.overlaid(run.left_image(name), occupancy, run, run.lines[moment]["ground"])
        panels.camera(left, picture, f"({letter}) frame {name}")
        panels.occupancies(middle, occupancy, run, "u-disparity grid")
        panels.grid(right, run.arrays("grids", name)["occupancy"], run, "filtered")
    panels.legend_below(axes[-1][0], ((panels.UPRIGHT, "upright, P(T) > 0.75"), (panels.ROAD, "road, P(T) < 0.4")))
    return figure


def figure_8(run, place, rates):
    name = run.names[place]
    runs = [run, *rates]
    figure = sheet("Figure 8. Influence of P_FP and P_FN", [source_line(run, place), filter_line(run, place)],
                   4.6 * len(runs), 8.5)
    for (layer, text), row in zip((("observed", "frame alone"), ("occupancy", "filtered")),
                                  figure.subplots(2, len(runs), squeeze=False)):
        for other, axes in zip(runs, row):
            config = bin_parameters(other)
            rated = f"P_FP = {config['false_positive']:g}, P_FN = {config['false_negative']:g}"
            panels.grid(axes, other.arrays("grids", name)[layer], run, f"{text}, {rated}")
    return figure


def figure_9(run, place, compared):
    grids = run.arrays("grids", run.names[place])
    figure = sheet("Figure 9. Beside the lidar", [source_line(run, place)], 16, 6)
    axes = figure.subplots(1, 3)
    panels.grid(axes[0], grids["observed"], run, "(a) frame alone")
    panels.grid(axes[1], grids["occupancy"], run, "(b) filtered")
    points = in_vehicle(compared["sweep"], run.rig, run.lines[place]["ground"])
    panels.scan(axes[2], points, run, "(c) lidar, from above")
    return figure


def draw(folder, frame=None, without_gaussian=None, rates=(), compared=None):
    """The figures by their number, and sentences about those that are left out."""
    run = Run(folder)
    place = run.place(frame)
    name = run.names[place]
    arrays = {}
    if compared is not None and (Path(compared) / f"{name}.npz").is_file():
        arrays = dict(np.load(Path(compared) / f"{name}.npz"))
    config = bin_parameters(run)
    with matplotlib.rc_context(STYLE):
        figures = {1: figure_1(config), 2: figure_2(config), 3: figure_3(run, place), 7: figure_7(run, place)}
        left_out = []
        for number, needed, make, reason in (
                (4, without_gaussian, lambda: figure_4(run, place, Run(without_gaussian)),
                 "it needs a run without the Gaussian (--without-gaussian)"),
                (6, "nearest_obstacle" in arrays, lambda: figure_6(run, place, arrays),
                 "it needs what stereogrid-compare --grids leaves (--compared)"),
                (8, rates, lambda: figure_8(run, place, [Run(rate) for rate in rates]),
                 "it needs runs with other error rates (--rates)"),
                (9, "sweep" in arrays, lambda: figure_9(run, place, arrays), f"frame {name} has no lidar sweep")):
            if needed:
                figures[number] = make()
            else:
                left_out.append(f"Figure {number} is left out: {reason}.")
    return figures, left_out


def save(figures, out):
    try:
        Path(out).mkdir(parents=True, exist_ok=True)
        with matplotlib.rc_context(STYLE):
            for number, figure in sorted(figures.items()):
                figure.savefig(Path(out) / f"figure_{number}.png")
    except OSError as error:
        raise Complaint(f"{out}: cannot be written ({error.strerror}).") from error


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", help="what `stereogrid run --save-stages --out` has left")
    parser.add_argument("--out", required=True, help="folder for figure_1.png and so on")
    parser.add_argument("--frame", metavar="NAME", help="the frame to draw (default: the run's last)")
    parser.add_argument("--without-gaussian", metavar="RUN", help="the same with both sigmas 0, for figure 4")
    parser.add_argument("--rates", metavar="RUN", nargs="+", default=[],
                        help="the same with another P_FP or P_FN, for figure 8")
    parser.add_argument("--compared", metavar="DIR",
                        help="what stereogrid-compare --grids has left of the same frames, for figures 6 and 9")
    given = parser.parse_args()
    try:
        figures, left_out = draw(given.run, given.frame, given.without_gaussian, given.rates, given.compared)
        save(figures, given.out)
    except Complaint as complaint:
        sys.exit(f"figures.py: {complaint}")
    print("\n".join(left_out + [f"figures in {given.out}"]))


if __name__ == "__main__":
    main()
