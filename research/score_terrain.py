#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Scores random terrain layouts, pooled over their seeds, and the course with 24 hazards, as Markdown tables.

score_terrain.py TOOL [FIRST-LAST...] [--robot] [--course]
"""
import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
from score_runs import evaluated, print_table, text_of  # noqa: E402

SHARES = {"drivable_free": ("drivable", "free"), "drivable_occupied": ("drivable", "occupied"), "edges_found": ("edges", "edges found"),
          "objects_found": ("objects", "objects found"), "rises_found": ("rises", "rises found"), "deadly_share": ("deadly", "deadly")}
GRIDS = ("observed", "occupancy")
COURSE = {"hazards": "hazards", "hazards_found": "found", "harmless": "harmless", "harmless_marked": "marked"}
ZONES = {"deadly": "deadly cells", "deadly_free": "of them free"}


def pooled(tool: str, seeds: range, robot: bool) -> dict:
    """By grid and range, by share: sum and count."""
    sums = {}
    options = ["--preset", "robot"] if robot else []
    for seed in seeds:
        source = f"scene:terrain?kind=random&seed={seed}" + ("&camera=robot" if robot else "")
        series = evaluated(tool, source, options)["series"]
        for grid in GRIDS:
            for distance, band in series[grid]["terrain"]["ranges"].items():
                for share, (of, _) in SHARES.items():
                    value = band.get(share)
                    value = value["value"] if isinstance(value, dict) else value
                    if band.get(of) and value is not None:
                        one = sums.setdefault((grid, distance), {}).setdefault(share, [0.0, 0])
                        one[0] += value * band[of]
                        one[1] += band[of]
    return sums


def layout_rows(tool: str, spans: list, robot: bool) -> list:
    rows = []
    for span in spans:
        first, last = map(int, span.split("-"))
        for (grid, distance), sums in pooled(tool, range(first, last + 1), robot).items():
            means = {share: total / count for share, (total, count) in sums.items()}
            rows.append([span, grid, distance, *(text_of(means.get(share), 4) for share in SHARES)])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("spans", nargs="*", metavar="FIRST-LAST", help="seeds")
    parser.add_argument("--robot", action="store_true", help="its camera and preset")
    parser.add_argument("--course", action="store_true")
    arguments = parser.parse_args()
    print_table("layouts", ["seeds", "grid", "range, m", *(title for _, title in SHARES.values())],
                layout_rows(arguments.tool, arguments.spans, arguments.robot))
    if arguments.course:
        series = evaluated(arguments.tool, "scene:course?frames=210", [])["series"]
        courses = {grid: series[grid]["terrain"]["course"] for grid in GRIDS}
        print_table("course", ["grid", *COURSE.values(), *ZONES.values()],
                    [[grid, *(str(course[figure]) for figure in COURSE),
                      *(str(sum(zone[figure] for zone in course["zones"])) for figure in ZONES)] for grid, course in courses.items()])


if __name__ == "__main__":
    main()
