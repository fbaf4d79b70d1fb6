#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""scripts/gpu_report.py on what ptxas says about two kernels, one of which is a test's."""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "scripts" / "gpu_report.py"
LOG = """ptxas info    : Compiling entry function '_ZN10stereogrid12filter_cellsILi1EEEvPf' for 'sm_90'
ptxas info    : Function properties for _ZN10stereogrid12filter_cellsILi1EEEvPf
    64 bytes stack frame, 100 bytes spill stores, 28 bytes spill loads
ptxas info    : Used 72 registers, used 1 barriers, 16384 bytes smem, 400 bytes cmem[0]
ptxas info    : Compiling entry function '_ZN10stereogrid4test4scanEPKi' for 'sm_90'
ptxas info    : Used 12 registers
"""


def said(*arguments: str) -> str:
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=True).stdout


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "build.log").write_text(LOG)
        (folder / "results.tsv").write_text("backend_test\tpassed\nbench\tno device\n")
        lines = said("resources", str(folder / "build.log")).splitlines()
        assert len(lines) == 3, lines
        assert lines[2] == "| `filter_cells<1>` | sm_90 | 72 | 16384 | 64 | 128 |", lines[2]
        report = json.loads(said("join", str(folder)))
        assert report["results"] == {"backend_test": "passed", "bench": "no device"}, report
        assert report["date"] and report["machine"] and report["commit"], report
        assert report["resources"][0]["registers"] == 72, report
        (folder / "build.log").unlink()  # built with another folder for the report
        assert json.loads(said("join", str(folder)))["resources"] is None


if __name__ == "__main__":
    main()
