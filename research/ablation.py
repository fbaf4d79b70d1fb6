#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Changes one option of the default preset at a time and scores the grids against lidar: prints Markdown
tables, which scripts/measure.py keeps.

ablation.py DRIVE... [--set KEY=VALUE ...]     DRIVE: a recording with lidar; --set: for every run
"""
import argparse
import pathlib
import sys
import tempfile

import stereogrid as sg

CHANGES = [
    ("as it is", []),
    ("rows do not follow the roll", ["u_disparity.follow_roll=false"]),
    ("low pixels are obstacles", ["u_disparity.obstacle_min_height_m=0"]),
    ("low: below 0.15 m", ["u_disparity.obstacle_min_height_m=0.15"]),
    ("largest bin instead of rays", ["projection.model=bins"]),
    ("matches rejected as in `paper`", ["matching.uniqueness=0.02", "matching.left_right_px=1", "matching.cost_limit=1", "matching.speckle_px=60", "matching.road_speckle_px=60"]),
    ("nothing rejected but by left-right", ["matching.speckle_px=0", "matching.road_speckle_px=0", "matching.texture=0", "matching.cost_limit=1"]),
    ("window 7", ["matching.window_px=7"]),
    ("window 11", ["matching.window_px=11"]),
    ("window 13", ["matching.window_px=13"]),
    ("window 21 (the paper's)", ["matching.window_px=21"]),
    ("rows not aligned", ["matching.align_rows=false"]),
]
FIGURES = [("balanced_log_loss", 3), ("auc", 3), ("iou_occupied", 3), ("missed", 3), ("calibration_error", 3),
           ("hidden_recall", 2)]


def scores(drive, settings):
    """{series: figures} of 3–20 m."""
    config = sg.preset("default")
    for setting in settings:
        config.set(*setting.split("=", 1))
    recording = sg.open(drive)
    with tempfile.TemporaryDirectory() as folder:
        with sg.RunWriter(folder, recording, sg.Pipeline(config, recording.rig, stages=False)) as run:
            for frame in run:
                run.process(frame)
        series = sg.evaluate(folder, drive, truth="lidar")["series"]
    return {name: series[name]["bands"]["3-20"] for name in ("observed", "occupancy")}


def cells(figures):
    values = (figures[name] for name, _ in FIGURES)
    numbers = (value["value"] if isinstance(value, dict) else value for value in values)
    return [f"{number:.{digits}f}" if number is not None else "–" for number, (_, digits) in zip(numbers, FIGURES)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("drives", nargs="+")
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    parser.add_argument("--only", nargs="+", metavar="TITLE", help="only changes whose title begins so")
    arguments = parser.parse_args()
    for drive in arguments.drives:
        print(f"\n**{pathlib.Path(drive).name}**\n")
        print("| changed | observed: log-loss | AUC | IoU | missed | ECE | hidden | occupancy: log-loss | AUC | IoU | missed |")
        print("|" + "---|" * 11)
        chosen = [change for change in CHANGES if not arguments.only or change[0].startswith(tuple(arguments.only))]
        for number, (title, changes) in enumerate(chosen, 1):
            print(f"\r{number} of {len(chosen)}: {title:40}", end="", file=sys.stderr)
            found = scores(drive, arguments.settings + changes)
            print("| " + " | ".join([title, *cells(found["observed"]), *cells(found["occupancy"])[:4]]) + " |", flush=True)
    print(file=sys.stderr)


if __name__ == "__main__":
    main()
