#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the pipeline on inputs with lidar or exact truth or labelled boxes and prints the scores of their grids and
obstacles, 3–20 m ahead, and of motion where the truth is exact, as Markdown tables. scripts/measure.py keeps them.

score_runs.py TOOL INPUT... [--preset NAME] [--set KEY=VALUE ...] [--poses NAME] [--table grids|obstacles|motion ...]
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

GRIDS = {"balanced_log_loss": "log-loss", "auc": "AUC", "iou_occupied": "IoU occupied", "iou_free": "IoU free",
         "missed": "missed", "false_alarms": "false alarms", "known": "known", "calibration_error": "calibration error",
         "hidden_recall": "hidden: recall at 1 %", "hidden_recall_clear": "… without borders"}
LABELS = {"3-20": "all", "3-20 clear": "clear"}  # the second: without ground that the camera cannot see (lidar)
MOTION = {"speed_error_mps": ("speed error, m/s", 1, 2), "direction_error_deg": ("direction error, °", 1, 1),
          "id_switches": ("other id", 1, 0), "cell_velocity_error_mps": ("velocity error of moving cells, m/s", 1, 2),
          "static_moving": ("static cells that seem to move, %", 100, 1),
          "gone_within_half_second": ("cells left that fall below 0.3 within half a second, %", 100, 0),
          "hidden_alive": ("hidden frames in which it is believed, %", 100, 0)}


OBSTACLES = {"separate": ("found alone", 2), "merged": ("merged", 2), "split": ("split", 2),
             "free_covered": ("free cells covered", 3), "moving_wrong": ("moving that do not", 2), "moving_cells": ("cells that move", 0),
             "moving_cells_standing": ("… by things that stand", 2),
             "speed_error_mps": ("speed error, m/s", 2), "area_p90_m2": ("area of 90 %, m²", 1)}
TRACKING = {"mota": ("MOTA", 2), "idf1": ("IDF1", 2), "id_switches": ("other id", 0)}


def evaluated(tool: str, source: str, options: list) -> dict:
    """Result of `stereogrid evaluate --json`."""
    with tempfile.TemporaryDirectory() as folder:
        scores = Path(folder) / "scores.json"
        subprocess.run([tool, "run", source, "--out", f"{folder}/run", *options], check=True, capture_output=True)
        subprocess.run([tool, "evaluate", f"{folder}/run", "--json", scores], check=True, capture_output=True)
        return json.loads(scores.read_text(encoding="utf-8"))


def text_of(value: "float | None", digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def row(*cells: str) -> str:
    return "| " + " | ".join(cells) + " |"


def print_table(title: str, columns: list, rows: list) -> None:
    if rows:
        print(f"**{title}**\n", row(*columns), row(*["---"] * len(columns)), *(row(*cells) for cells in rows), "", sep="\n")


def grid_rows(name: str, series: dict) -> list:
    return [[name, str(band["frames"]), grid, labels, *(text_of(band[figure]["value"], 3) for figure in GRIDS)]
            for grid in ("observed", "occupancy") for key, labels in LABELS.items()
            if (band := series[grid]["bands"].get(key))]


def motion_row(name: str, motion: dict) -> list:
    figures = ((motion[figure], scale, digits) for figure, (_, scale, digits) in MOTION.items())
    return [name, f"{motion['found']} of {motion['sightings']}",
            *(text_of(None if value is None else scale * value, digits) for value, scale, digits in figures)]


def obstacle_row(name: str, obstacles: dict) -> list:
    tracking = obstacles["tracking"]
    return [name, str(obstacles["things"]), *(text_of(obstacles[key], digits) for key, (_, digits) in OBSTACLES.items()),
            str(obstacles["moving"]), *(text_of(tracking[key], digits) for key, (_, digits) in TRACKING.items())]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--preset", default="default")
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    parser.add_argument("--poses")
    parser.add_argument("--table", dest="tables", action="append", choices=("grids", "obstacles", "motion"),
                        help="only this one; all where none is named")
    arguments = parser.parse_args()
    options = ["--preset", arguments.preset, *(part for setting in arguments.settings for part in ("--set", setting))]
    options += ["--poses", arguments.poses] if arguments.poses else []
    grids, motion, obstacles = [], [], []
    for source in arguments.inputs:
        name = Path(source).name
        scores = evaluated(arguments.tool, source, options)
        series = scores["series"]
        if scores.get("obstacles"):
            obstacles.append(obstacle_row(name, scores["obstacles"]))
        if series:
            grids += grid_rows(name, series)
        if "motion" in series.get("occupancy", {}):
            motion.append(motion_row(name, series["occupancy"]["motion"]))
    tables = {"grids": (["input", "frames", "grid", "labels", *GRIDS.values()], grids),
              "obstacles": (["input", "things", *(title for title, _ in OBSTACLES.values()), "said to move",
                             *(title for title, _ in TRACKING.values())], obstacles),
              "motion": (["input", "found", *(title for title, _, _ in MOTION.values())], motion)}
    for name in arguments.tables or tables:
        print_table(name, *tables[name])


if __name__ == "__main__":
    main()
