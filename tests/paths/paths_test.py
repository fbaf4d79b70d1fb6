#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the same scenes from every source, on every device, with every preset, and compares.

paths_test.py TOOL [--emulator LIBRARY] [--python INTERPRETER] [--turn N] [--rows PATTERN]

--emulator is the CUDA library of the emulator, --python an interpreter whose PYTHONPATH has the package; rows that need
one that is not given are left out. --turn selects the rows that are run beside those of every turn; by default it is the
number of commits. --rows runs all rows that match a pattern such as 'edge/npy/*' instead."""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from itertools import combinations, product
from pathlib import Path

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: needs numpy (Debian: python3-numpy)")
    sys.exit(77)

from checks import Finding, check_row
from runs import Lab, RunFailed
from sources import SOURCES
from tables import DEVICES, EXTRINSICS, GAPS, POSES, PRESETS, SCENES, TURN_ROWS, Row

AT_A_TIME = 2


def all_rows(devices: "set[str]", has_python: bool) -> "list[Row]":
    """The product, without what does not exist; in an order that mixes the entries of all tables."""
    rows = [Row(*entries) for entries in product(SCENES, SOURCES, DEVICES, PRESETS, EXTRINSICS, POSES)]
    rows = [row for row in rows if row.device in devices and row.extrinsics in SOURCES[row.source].extrinsics and
            (has_python or SOURCES[row.source].command != "python") and
            not (row.source == "folder" and row.device == "cpu") and
            # --frames keeps the world of the scene, a folder without its first frames begins a new one
            not (row.source == "scene" and SCENES[row.scene].first and row.poses == "file")]
    random.Random(1).shuffle(rows)
    return rows


def pairs_of(row: Row) -> "set[tuple]":
    return set(combinations(enumerate(row), 2))


def covering(rows: "list[Row]") -> "list[Row]":
    """Rows that contain each pair of entries of two tables that there is; the next one is that with most new pairs. Most
    are of the CPU, where a row costs least and has most checks."""
    pairs = {row: pairs_of(row) for row in rows}
    chosen: "list[Row]" = []
    covered: "set[tuple]" = set()
    for candidates in ([row for row in rows if row.device == "cpu"], rows):
        missing = set().union(*(pairs[row] for row in candidates)) - covered
        while missing:
            best = max(candidates, key=lambda row: len(pairs[row] & missing))
            missing -= pairs[best]
            covered |= pairs[best]
            chosen.append(best)
    return chosen


def selected(rows: "list[Row]", turn: int, part: int) -> "list[Row]":
    """The covering rows, and `part` of the others, the next ones in each turn."""
    fixed = covering(rows)
    others = [row for row in rows if row not in set(fixed)]
    begin = turn * part % max(len(others), 1)
    return fixed + (others + others)[begin:begin + min(part, len(others))]


def default_turn() -> int:
    command = ["git", "-C", str(Path(__file__).parent), "rev-list", "--count", "HEAD"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return 0
    return int(done.stdout) if done.returncode == 0 else 0


def findings_of(lab: Lab, row: Row) -> "list[Finding]":
    try:
        return list(check_row(lab, row))
    except RunFailed as error:
        return [Finding(row, "runs", False, "exit code 0", error)]


def is_gap(finding: Finding) -> bool:
    return any(fnmatch(f"{finding.row}: {finding.check}", pattern) for pattern in GAPS)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tool")
    parser.add_argument("--emulator", default="")
    parser.add_argument("--python", default="")
    parser.add_argument("--turn", type=int, default=None)
    parser.add_argument("--rows", default="")
    parser.add_argument("--verbose", action="store_true", help="print every finding")
    given = parser.parse_args()
    rows = all_rows(set(DEVICES) - (set() if given.emulator else {"cuda"}), bool(given.python))
    turn = default_turn() if given.turn is None else given.turn
    chosen = [row for row in rows if fnmatch(str(row), given.rows)] if given.rows else selected(rows, turn, TURN_ROWS)
    begin, failed, count, gaps = time.monotonic(), 0, 0, 0
    with tempfile.TemporaryDirectory(prefix="stereogrid-paths-") as work, ThreadPoolExecutor(AT_A_TIME) as threads:
        lab = Lab(given.tool, Path(work), given.emulator, given.python)
        for findings in threads.map(lambda row: findings_of(lab, row), chosen):
            for finding in findings:
                count += 1
                failed += not finding.holds and not is_gap(finding)
                gaps += not finding.holds and is_gap(finding)
                if given.verbose or not finding.holds:
                    word = "holds" if finding.holds else "known gap" if is_gap(finding) else "FAILED"
                    print(f"{word}: {finding}", flush=True)
    print(f"turn {turn}: {len(chosen)} of {len(rows)} rows, {count} checks, {failed} failed, {gaps} known gaps, "
          f"{time.monotonic() - begin:.0f} s")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
