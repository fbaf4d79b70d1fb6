#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions of a frame's stages with callgrind, which has AVX2 whatever the processor: figures that do not
depend on what else runs.

instructions.py BENCH_INSTRUCTIONS            prints a Markdown table, for scripts/measure.py
instructions.py BENCH_INSTRUCTIONS --check    compares with bench/results.json; exit status 77: skipped
instructions.py BENCH_INSTRUCTIONS --neon COUNT_STAGES   likewise for 64-bit ARM in qemu, beside the kept ones of AVX2
                                              (scripts/check-neon.sh --instructions)
"""
import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

KEPT = Path(__file__).resolve().parent / "results.json"
TOLERANCE = 0.03
SKIPPED = 77

# Functions whose instructions count, with those of the functions that they call; dashes: part of the one before.
STAGES = {
    "frame": "FramePipeline::process(", "match": "HostStages<stereogrid::Cpu>::match(",
    "– correlation": "stereogrid::correlate_band(", "– decision": "stereogrid::classify_row(",
    "ground": "CameraPipeline::fit_ground(", "terrain": "CameraPipeline::find_terrain(",
    "checks, segments": "CameraPipeline::check(", "features": "CameraPipeline::track_features(",
    "observed grid": "HostStages<stereogrid::Cpu>::observe(", "filter": "HostStages<stereogrid::Cpu>::filter(",
    "tracks": "FramePipeline::update_tracks("}

# Instructions that a core dispatches in a cycle, and those in vector registers that it executes.
CORES = {"A78AE": (6, 2), "A76": (4, 2)}


def kept_table() -> dict:
    return json.loads(KEPT.read_text(encoding="utf-8"))["instructions"]["tables"][0]


def count_neon(program: str, plugin: str) -> tuple:
    """As count(); of each stage a pair: all instructions, and data processing in vector registers."""
    symbols = subprocess.run(["nm", "-C", program], capture_output=True, text=True, check=True).stdout
    functions = [line.split(" ", 2) for line in symbols.splitlines() if re.match(r"[0-9a-f]+ [tTwW] ", line)]
    names = {}
    for stage, function in STAGES.items():
        for address, _, name in functions:
            if re.match(rf"(stereogrid::)?{re.escape(function)}", name) and "{lambda" not in name and " [clone" not in name:
                names[f"f{len(names)}"] = (stage, address)
    arguments = ",".join(f"{name}=0x{address}" for name, (_, address) in names.items())
    run = subprocess.run(["qemu-aarch64", "-plugin", f"{plugin},{arguments}", program], capture_output=True, text=True,
                         check=True)
    about = run.stdout.strip()
    frames = int(re.search(r"(\d+) frames", about)[1])
    counts = {}
    for name, *found in (line.split() for line in run.stderr.splitlines()):
        stage = names[name][0]
        counts[stage] = max(counts.get(stage, (0, 0)), tuple(int(one) / frames / 1e6 for one in found))
    return about, counts


def print_neon(about: str, counts: dict) -> None:
    cores = " | ".join(f"{name}, million cycles at least" for name in CORES)
    print(f"**{about}**\n\n| stage | AVX2 | NEON | of them vector | NEON / AVX2 | {cores} |\n|---|---|---|---|---|---|---|")
    for stage, of_avx2 in kept_table()["rows"]:
        every, vector = counts.get(stage, (0, 0))
        if every == 0:
            print(f"| {stage} | {of_avx2:.2f} | – | – | – |" + " – |" * len(CORES))
            continue
        cycles = " | ".join(f"{max(every / wide, vector / of_vector):.1f}" for wide, of_vector in CORES.values())
        print(f"| {stage} | {of_avx2:.2f} | {every:.2f} | {vector:.2f} | {every / of_avx2:.2f} | {cycles} |")


def count(*program: str) -> tuple:
    """Text that the program prints, and millions of instructions per frame of each stage."""
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "profile"
        run = subprocess.run(["valgrind", "-q", "--tool=callgrind", f"--callgrind-out-file={profile}", *program],
                             capture_output=True, text=True, check=False)
        if run.returncode != 0:
            sys.exit(f"valgrind, exit status {run.returncode}: {run.stderr}")
        listing = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", profile],
                                 capture_output=True, text=True, check=True).stdout
    about = run.stdout.strip()
    frames = int(re.search(r"(\d+) frames", about)[1])
    lines = [re.match(r" *([\d,]+) +\(.*?\) +\S*?:(.*)", line) for line in listing.splitlines()]
    found = [(int(line[1].replace(",", "")), line[2]) for line in lines if line and not line[2].startswith("tbb::")]
    counts = {}
    for stage, function in STAGES.items():
        of_stage = [instructions for instructions, name in found if function in name.split(" [")[0]]
        if not of_stage:
            sys.exit(f"No function {function}: mend STAGES in {Path(__file__).name}.")
        counts[stage] = max(of_stage) / frames / 1e6
    return about, counts


def check(about: str, counts: dict) -> int:
    table = kept_table()
    if table["title"] != about:
        print(f"Skipped: counts are kept for {table['title']}; this is {about}.")
        return SKIPPED
    status = 0
    for stage, kept in table["rows"]:
        change = counts[stage] / kept - 1
        if abs(change) > TOLERANCE:
            print(f"{stage}: {counts[stage]:.2f} million instructions per frame instead of {kept} ({change:+.1%}, allowed "
                  f"±{TOLERANCE:.0%}). If that is meant, measure again: scripts/measure.py instructions -- …")
            status = 1
    return status


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--neon", metavar="COUNT_STAGES")
    given = parser.parse_args()
    if given.neon:
        print_neon(*count_neon(given.program, given.neon))
        return 0
    if not shutil.which("valgrind"):
        print("Skipped: valgrind is missing. Debian and Ubuntu: apt-get install valgrind")
        return SKIPPED
    about, counts = count(given.program)
    counts["frame, 80 × 80 m"] = count(given.program, "80")[1]["frame"]
    if given.check:
        return check(about, counts)
    print(f"**{about}**\n\n| stage | million instructions per frame |\n|---|---|")
    for stage, instructions in counts.items():
        print(f"| {stage} | {instructions:.2f} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
