#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a program that prints Markdown tables and keeps them in bench/results.json, with date, machine and commit.

measure.py NAME [--section TEXT --title TEXT --about TEXT] -- COMMAND...

The three texts are needed for a new NAME; a known one keeps its own unless others are given. Notes on the former
figures are dropped. For example:

measure.py chain -- build/release/bin/bench_chain
measure.py options -- research/ablation.py DRIVE... --set grid.length_m=30
"""
import argparse
import datetime
import os
import re
import shutil
import subprocess
import sys
from decimal import Decimal
from pathlib import Path

import results

HEADING = re.compile(r"#+ +(.+)")
BOLD = re.compile(r"\*\*([^*]+)\*\*(.*)")
TEXTS = ("section", "title", "about")
NUMBER = re.compile(r"-?(?:0|[1-9]\d*)(?:\.\d+)?")  # as JSON has it


def cells_of(line: str) -> list:
    return [cell.strip() for cell in re.sub(r"^\||\|$", "", line.strip()).split("|")]


def value_of(cell: str):
    if cell in ("–", ""):
        return None if cell else ""
    return Decimal(cell) if NUMBER.fullmatch(cell) else cell


def tables_of(markdown: str) -> list:
    """Every table; its title is the heading above it and a bold line since the table before."""
    tables, heading, bold, inside = [], "", "", False
    for line in markdown.splitlines():
        if not line.startswith("|"):
            inside = False
            if match := HEADING.fullmatch(line):
                heading, bold = match[1], ""
            elif match := BOLD.fullmatch(line):
                bold = match[1] + match[2]
        elif not inside:
            tables.append({"title": ": ".join(filter(None, (heading, bold))), "columns": cells_of(line), "rows": []})
            inside, bold = True, ""
        elif not re.fullmatch(r"[|\s:-]+", line):
            tables[-1]["rows"].append([value_of(cell) for cell in cells_of(line)])
    return tables


# Highway's targets on x86 that the core is compiled for, best first, with the flags of /proc/cpuinfo that each needs
SIMD_TARGETS = {"AVX3_DL": ("avx512_vbmi2", "avx512_vnni", "vaes"), "AVX2": ("avx2", "fma", "bmi2"), "SSE4": ("sse4_1",)}


def machine(cpuinfo: str | None = None, cores: int | None = None) -> str:
    """Cores, processor with family, model and stepping, and the instructions that decide on speed: one name may stand
    for processors of which one takes twice as long."""
    cpuinfo = Path("/proc/cpuinfo").read_text("utf-8") if cpuinfo is None else cpuinfo
    cores = len(os.sched_getaffinity(0)) if cores is None else cores

    def field(name: str) -> str:
        found = re.search(rf"^{name}\s*: (.+)$", cpuinfo, re.MULTILINE)
        return found[1] if found else "unknown"
    flags = set(field("flags").split())
    target = next((name for name, needed in SIMD_TARGETS.items() if flags.issuperset(needed)), "unknown")
    return (f"{cores} cores, {field('model name')}, family {field('cpu family')}, model {field('model')}, "
            f"stepping {field('stepping')}, SIMD {target}")


def gpus() -> str:
    """Names and drivers of this machine's GPUs, each behind a comma; nothing without any."""
    if shutil.which("nvidia-smi") is None:
        return ""
    asked = ["nvidia-smi", "--query-gpu=name,driver_version", "--format=csv,noheader"]
    named = subprocess.run(asked, capture_output=True, text=True, check=False)
    return "".join(f", {line.replace(', ', ', driver ')}" for line in named.stdout.splitlines()) if not named.returncode else ""


def git(*arguments: str) -> str:
    return subprocess.run(["git", "-C", results.ROOT, *arguments], capture_output=True, text=True, check=False).stdout


def commit() -> str:
    """Commit of the sources; empty: tracked files differ from it, except the figures themselves."""
    head = git("rev-parse", "--short", "HEAD").strip()
    changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", ":!bench/results.json")
    return "" if changed else head or "unknown"


def shown(command: list) -> str:
    """Without the folders of this machine, in lists with commas and pairs A=B neither."""
    def name_of(part: str) -> str:
        return Path(part).name if os.path.exists(part) else part
    return " ".join("".join(map(name_of, re.split("([,=])", part))) for part in command)


def arguments(words: list) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("name")
    for text in TEXTS:
        parser.add_argument(f"--{text}")
    end = words.index("--") if "--" in words else len(words)
    parsed = parser.parse_args(words[:end])
    parsed.command = words[end + 1:]
    if not parsed.command:
        parser.error("which command?")
    return parsed


def main() -> int:
    options = arguments(sys.argv[1:])
    measurements = results.load()
    measurement = measurements.get(options.name, {})
    for text in TEXTS:
        measurement[text] = getattr(options, text) or measurement.get(text)
        if not measurement[text]:
            print(f"{options.name} is new: give --{text}.", file=sys.stderr)
            return 64
    measured = commit()
    if not measured:
        print("The working tree has changes that are not committed. Commit them, then measure.", file=sys.stderr)
        return 64
    run = subprocess.run(options.command, stdout=subprocess.PIPE, text=True, check=False)
    print(run.stdout, end="")
    tables = tables_of(run.stdout)
    if run.returncode != 0 or not tables:
        print(f"Exit status {run.returncode}, {len(tables)} tables: nothing is kept.", file=sys.stderr)
        return 1
    measurement |= {"date": datetime.date.today().isoformat(), "commit": measured,
                    "machine": machine() + gpus(),
                    "command": shown(options.command), "tables": tables, "notes": []}
    results.save(measurements | {options.name: measurement})
    return 0


if __name__ == "__main__":
    sys.exit(main())
