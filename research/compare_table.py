#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Scores of other methods beside this library's variants, as Markdown tables, which scripts/measure.py keeps. The grids
that scripts/score_runs.py scores are left out.

compare_table.py COMPARE INPUT... [--set KEY=VALUE ...]     COMPARE: stereogrid-compare
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "scripts"))
from score_runs import GRIDS, LABELS, print_table, text_of  # noqa: E402

OWN = ("observed", "filter_joint")


def print_methods(name: str, series: dict) -> None:
    first = next(iter(series.values()))["bands"]["3-20"]
    title = (f"{name} ({first['frames']} frames, {first['cells']} cells, {first['occupied']} occupied, "
             f"{first['hidden_occupied']} of them partly hidden)")
    rows, over_time = [], False
    for method, scored in series.items():
        if method in OWN:
            continue
        if scored["over_time"] and not over_time:
            rows.append(["*over time*", *[""] * (len(GRIDS) + 1)])
        over_time = scored["over_time"]
        rows += [[f"`{method}`", labels, *(text_of(figures[key]["value"], 3) for key in GRIDS)]
                 for band, labels in LABELS.items() if (figures := scored["bands"].get(band))]
    print_table(title, ["method", "labels", *GRIDS.values()], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("compare")
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("--set", action="append", default=[], dest="settings", metavar="KEY=VALUE")
    given = parser.parse_args()
    options = [part for setting in given.settings for part in ("--set", setting)]
    for source in given.inputs:
        with tempfile.TemporaryDirectory() as folder:
            scores = Path(folder) / "scores.json"
            subprocess.run([given.compare, "-q", source, *options, "--json", scores], check=True, stdout=subprocess.DEVNULL)
            print_methods(Path(source).name, json.loads(scores.read_text(encoding="utf-8"))["series"])


if __name__ == "__main__":
    main()
