#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Markdown tables of what `stereogrid-compare --json FILE` leaves; scripts/measure.py keeps them.

Usage: compare_table.py TITLE=FILE ...
"""
import json
import sys

BAND = "3-20"
LABELS = {BAND: "all", f"{BAND} clear": "clear"}  # the second: without ground that the camera cannot see (lidar)
COLUMNS = (("balanced_log_loss", "log-loss"), ("auc", "AUC"), ("iou_occupied", "IoU occupied"), ("iou_free", "IoU free"),
           ("missed", "missed"), ("known", "known"), ("calibration_error", "calibration error"),
           ("hidden_recall", "hidden: recall at 1 %"), ("hidden_recall_clear", "… without borders"))
HIDDEN_BANDS = ("3-10", "10-20")


def text_of(value: "float | None") -> str:
    return "–" if value is None else f"{value:.3f}"


def print_table(title: str, series: dict) -> None:
    first = next(iter(series.values()))["bands"][BAND]
    print(f"**{title}** ({first['frames']} frames, {first['cells']} cells, {first['occupied']} occupied, "
          f"{first['hidden_occupied']} of them partly hidden)\n")
    print("| method | labels | " + " | ".join(heading for _, heading in COLUMNS) + " |")
    print("|---" * (len(COLUMNS) + 2) + "|")
    over_time = False
    for name, method in series.items():
        if method["over_time"] and not over_time:
            print("| *over time* " + "|" * (len(COLUMNS) + 2))
        over_time = method["over_time"]
        for band, labels in LABELS.items():
            if figures := method["bands"].get(band):
                print(f"| `{name}` | {labels} | " + " | ".join(text_of(figures[key]["value"]) for key, _ in COLUMNS) + " |")
    print()


def print_hidden(drives: dict) -> None:
    print("| hidden: recall at 1 % | " + " | ".join(f"{title}, {band} m" for title in drives for band in HIDDEN_BANDS) + " |")
    print("|---" * (len(drives) * len(HIDDEN_BANDS) + 1) + "|")
    for name in next(iter(drives.values())):
        figures = [series[name]["bands"][band]["hidden_recall"]["value"] if name in series else None
                   for series in drives.values() for band in HIDDEN_BANDS]
        print(f"| `{name}` | " + " | ".join(map(text_of, figures)) + " |")


def main() -> int:
    if len(sys.argv) < 2 or not all("=" in argument for argument in sys.argv[1:]):
        print(__doc__, file=sys.stderr)
        return 64
    drives = {}
    for argument in sys.argv[1:]:
        title, _, path = argument.partition("=")
        with open(path, encoding="utf-8") as file:
            drives[title] = json.load(file)["series"]
    for title, series in drives.items():
        print_table(title, series)
    print_hidden(drives)
    return 0


if __name__ == "__main__":
    sys.exit(main())
