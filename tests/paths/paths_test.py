#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the same scenes from every source, on every device, with every preset, and compares.

paths_test.py TOOL [--emulator LIBRARY] [--python INTERPRETER] [--turn N] [--rows PATTERN]

--emulator is the CUDA library of the emulator, --python an interpreter whose PYTHONPATH has the package; rows that need
one that is not given are left out. --turn selects the rows that are run beside those of every turn; by default it is the
number of commits. --rows runs all rows that match a pattern such as 'edge/npy/*' instead."""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from fnmatch import fnmatch
from pathlib import Path

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: needs numpy (Debian: python3-numpy)")
    sys.exit(77)

from checks import Finding, check_row
from runs import Lab, RunFailed
from selection import all_rows, selected
from tables import DEVICES, GAPS, TURN_ROWS, Row

AT_A_TIME = 2


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
