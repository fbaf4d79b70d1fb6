#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables and JSON for scripts/gpu-check.sh.

gpu_report.py resources LOG    what ptxas -v said, as a Markdown table: a line per kernel and architecture
gpu_report.py join FOLDER      report.json of its results.tsv and build.log, with date, machine and commit
"""
import datetime
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import measure

ENTRY = re.compile(r"Compiling entry function '(\w+)' for '(sm_\w+)'")
STACK = re.compile(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads")
USED = re.compile(r"Used (\d+) registers")
SHARED = re.compile(r"(\d+) bytes smem")
NOT_OURS = re.compile(r"^(test|bench)::|_models\b")  # names of tests and benchmarks


def resources(text: str) -> list:
    kernels = []
    for line in text.splitlines():
        if match := ENTRY.search(line):
            kernels.append({"kernel": match[1], "architecture": match[2], "registers": 0, "shared_bytes": 0,
                            "stack_bytes": 0, "spilled_bytes": 0})
        elif kernels and (match := STACK.search(line)):
            kernels[-1]["stack_bytes"] += int(match[1])  # includes called functions
            kernels[-1]["spilled_bytes"] += int(match[2]) + int(match[3])
        elif kernels and (match := USED.search(line)):
            kernels[-1]["registers"] = int(match[1])
            shared = SHARED.search(line)
            kernels[-1]["shared_bytes"] = int(shared[1]) if shared else 0
    ours = (kernel for kernel in named(kernels) if not NOT_OURS.search(kernel["kernel"]))
    return sorted(ours, key=lambda kernel: (kernel["kernel"], kernel["architecture"]))


def named(kernels: list) -> list:
    """With readable names where c++filt is there."""
    if not kernels or shutil.which("c++filt") is None:
        return kernels
    names = subprocess.run(["c++filt", *(kernel["kernel"] for kernel in kernels)], capture_output=True, text=True,
                           check=True).stdout.splitlines()
    for kernel, name in zip(kernels, names):
        name = re.sub(r"\([A-Za-z_:]+\)(?=\d)", "", name)  # numbers of enumerators
        name = re.sub(r"\(anonymous namespace\)::|stereogrid::|_GLOBAL__N__\w+::", "", name)
        kernel["kernel"] = re.sub(r"^void ", "", re.sub(r"\(.*", "", name))
    return kernels


def table(kernels: list) -> str:
    numbers = {"registers": "registers", "shared_bytes": "shared memory, bytes", "stack_bytes": "stack, bytes",
               "spilled_bytes": "spilled, bytes"}
    lines = [f"| kernel | architecture | {' | '.join(numbers.values())} |", "| --- | --- |" + " ---: |" * len(numbers)]
    for kernel in kernels:
        lines.append(f"| `{kernel['kernel']}` | {kernel['architecture']} | "
                     + " | ".join(str(kernel[number]) for number in numbers) + " |")
    return "\n".join(lines)


def joined(folder: Path) -> dict:
    results = dict(line.split("\t") for line in (folder / "results.tsv").read_text().splitlines())
    log = folder / "build.log"
    return {"date": datetime.date.today().isoformat(), "machine": measure.machine() + measure.gpus(),
            "commit": measure.commit() or "uncommitted",
            "results": results, "resources": resources(log.read_text()) if log.exists() else None}


def main() -> int:
    command, *files = sys.argv[1:] or [""]
    if command == "resources" and len(files) == 1:
        print(table(resources(Path(files[0]).read_text())))
    elif command == "join" and len(files) == 1:
        print(json.dumps(joined(Path(files[0])), indent=1))
    else:
        print(__doc__, file=sys.stderr)
        return 64
    return 0


if __name__ == "__main__":
    sys.exit(main())
