#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Counts the instructions of a frame's stages with callgrind, which has AVX2 whatever the processor: figures that do not
depend on what else runs.

instructions.py BENCH_INSTRUCTIONS            prints a Markdown table, for scripts/measure.py
instructions.py BENCH_INSTRUCTIONS --check    compares with bench/results.json; exit status 77: skipped
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
    "checks": "CameraPipeline::check(", "segments": "CameraPipeline::find_segments(",
    "features": "CameraPipeline::track_features(", "observed grid": "HostStages<stereogrid::Cpu>::observe(",
    "filter": "HostStages<stereogrid::Cpu>::filter(", "tracks": "FramePipeline::update_tracks("}


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
    table = json.loads(KEPT.read_text(encoding="utf-8"))["instructions"]["tables"][0]
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
    given = parser.parse_args()
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
