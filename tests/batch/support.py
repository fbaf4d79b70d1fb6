# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tests of batches. The program is the first word of the command line."""
import filecmp
import json
import shutil
import subprocess
import sys
from pathlib import Path

tool_path = Path(sys.argv[1]).resolve()
SIZE = "&width=320&height=200"


def skip(why: str):
    print(f"SKIPPED: {why}")
    sys.exit(77)


def tool(*words, expect=0, **options) -> subprocess.CompletedProcess:
    command = [str(tool_path), "batch", *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    if expect is not None and done.returncode != expect:
        raise AssertionError(f"{' '.join(command)}: exit code {done.returncode}, not {expect}\n{done.stdout}{done.stderr}")
    return done


def status(plan: Path) -> dict:
    return json.loads(tool("status", plan, "--json").stdout)


def scene(frames: int, seed: int = 1) -> str:
    return f"scene:street?frames={frames}&seed={seed}{SIZE}"


def drive(folder: Path, seed: int) -> Path:
    subprocess.run([tool_path, "-q", "simulate", f"street?frames=4&seed={seed}{SIZE}", "--out", folder], check=True,
                   stdout=subprocess.DEVNULL)
    return folder


def make_plan(folder: Path, *words) -> Path:
    plan = folder / "plan"
    tool("plan", *words, "--out", plan)
    return plan


def copy_of(plan: Path, name: str) -> Path:
    """The same plan without any results. Digests do not depend on where a plan lies."""
    copy = plan.parent / name
    copy.mkdir()
    for file in ("plan.json", "manifest.jsonl", "manifest.index"):
        shutil.copy(plan / file, copy / file)
    return copy


def expect_equal(a: Path, b: Path):
    """Every file but those of times."""
    names = [sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()) for folder in (a, b)]
    assert names[0] == names[1], f"other files: {set(names[0]) ^ set(names[1])}"
    different = [name for name in names[0] if name != "timing.json" and not filecmp.cmp(a / name, b / name, shallow=False)]
    for name in (name for name in different[:1] if "json" in name):
        for left, right in zip((a / name).read_text().splitlines(), (b / name).read_text().splitlines()):
            if left != right:
                print(f"{name}:\n{left[:600]}\n{right[:600]}")
    assert not different, f"these differ: {different}"
    print(f"{len(names[0])} merged files are equal")
