#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Compares the results of two builds of the tool, or of two devices, to the bit: grids and stages array by array,
frames.jsonl and run.json without timing, version, device and config, in all presets. Prints the first difference of
each run; exit status 1 if any.

same_results.py OLD_TOOL NEW_TOOL INPUT...

Options for `stereogrid run` may follow a tool or an input in the same argument: "stereogrid --device cuda".
"""
import json
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

PRESETS = ("default", "robot", "paper")
LEFT_OUT = ("timing_ms", "version", "device", "threads", "config")
MISSING = "missing"


def run(tool: str, words: list, preset: str, out: Path) -> None:
    program, *options = shlex.split(tool)
    command = [program, "-q", "run", *words, *options, "--preset", preset, "--save-stages", "--out", str(out)]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(f"{done.stderr}exit status {done.returncode} of: {shlex.join(command)}")


def json_difference(old, new, place: str) -> "str | None":
    if isinstance(old, list) and isinstance(new, list):
        old, new = dict(enumerate(old)), dict(enumerate(new))
    if isinstance(old, dict) and isinstance(new, dict):
        parts = (json_difference(old.get(key, MISSING), new.get(key, MISSING), f"{place}/{key}") for key in {**old, **new})
        return next(filter(None, parts), None)
    return None if type(old) is type(new) and old == new else f"{place}: {old!s:.80} → {new!s:.80}"


def array_difference(old: Path, new: Path) -> "str | None":
    with np.load(old) as before, np.load(new) as after:
        for name in {**dict.fromkeys(before.files), **dict.fromkeys(after.files)}:
            if name not in before.files or name not in after.files:
                return f"{name}: only in the {'old' if name in before.files else 'new'} results"
            a, b = before[name], after[name]
            if (a.dtype, a.shape) != (b.dtype, b.shape):
                return f"{name}: {a.dtype}{a.shape} → {b.dtype}{b.shape}"
            if a.tobytes() != b.tobytes():
                i = np.flatnonzero((a.view(np.uint8) != b.view(np.uint8)).reshape(a.size, -1).any(axis=1))
                return f"{name}: {i.size} of {a.size} values, the first {a.flat[i[0]]} → {b.flat[i[0]]}"
    return None


def results_of(file: Path) -> list:
    """The objects of a JSON file without values that differ from run to run."""
    text = file.read_text(encoding="utf-8")
    lines = text.splitlines() if file.suffix == ".jsonl" else [text]
    return [{key: value for key, value in json.loads(line).items() if key not in LEFT_OUT} for line in lines]


def first_difference(old: Path, new: Path) -> "str | None":
    for pattern, difference in (("*.json*", lambda a, b: json_difference(results_of(a), results_of(b), "")),
                                ("grids/*.npz", array_difference), ("stages/*.npz", array_difference)):
        names = [sorted(str(file.relative_to(run)) for file in run.glob(pattern)) for run in (old, new)]
        if names[0] != names[1] or not names[0]:
            return f"other files: {', '.join(sorted(set(names[0]) ^ set(names[1]))) or 'no ' + pattern}"
        for name in names[0]:
            if found := difference(old / name, new / name):
                return f"{name}: {found}"
    return None


def main() -> int:
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    wanted = [(source, preset) for source in sys.argv[3:] for preset in PRESETS]
    found = []
    for source, preset in wanted:
        print(f"[{len(found) + 1}/{len(wanted)}] {source}, {preset}: ", end="", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            runs = [Path(folder) / name for name in ("old", "new")]
            for tool, out in zip(sys.argv[1:3], runs):
                run(tool, shlex.split(source), preset, out)
            found.append(first_difference(*runs))
        print(found[-1] or "equal", flush=True)
    return int(any(found))


if __name__ == "__main__":
    sys.exit(main())
