#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Usage: scripts/mutants.py [--jobs N] [--only TEXT] [--out FILE] [--check]

Makes the changes of mutants.txt, one token of src/ at a time, and runs the core's unit and chain tests: each should fail
one. A copy of the working tree in build/mutants is built once, with all changes in it; STEREOGRID_MUTANT selects one at run
time. Results are added to FILE (build/mutants/results.txt), a line each: killed, survived, or broken (does not compile).
Mutants that it has are skipped. Prints the table of docs/testing.md.
"""
import argparse
import collections
import concurrent.futures
import os
import re
import resource
import shutil
import subprocess
import sys
import threading
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIST = Path(__file__).with_suffix(".txt")
WORK = ROOT / "build" / "mutants"
TREE = WORK / "tree"
BUILD = TREE / "build" / "release"
CORE, CHAIN = TESTS = ["stereogrid_core_tests", "stereogrid_chain_tests"]
WALL_S = 1800
# unit tests that take longest
SLOW = ("SceneFlow*:ExtrinsicsSearch*:*HostileClock*:RigProblems*:*FilterOfEachModel*:Terrain*:Car*:*CallersResult*:"
        "MatchingTargets*:MatchingEquality*:Pipeline*:Projection*:*HostileInput*:Alignment*:SemiGlobal*:Matching.*:Subpixel*")
# folder of src/: those of them, and the chain tests, that most likely fail
FIRST = {"motion": ("SceneFlow*", "MotionChain*:Chain.*"), "obstacles": ("SceneFlow*", "*Standing*:MotionChain*"),
         "ground": ("ExtrinsicsSearch*:RigProblems*", "GroundChain*:ExtrinsicsChain*:Trust*"),
         "observation": ("Projection*", "HalfHidden*:LowObstacles*"), "filter": ("*FilterOfEachModel*", "*Standing*:Chain.*"),
         "matching": ("Matching*:SemiGlobal*", "LowObstacles*:Chain.*"), "images": ("Alignment*", "AlignmentChain*"),
         "terrain": ("Terrain*:Car*", "Terrain*:LowObstacles*")}

# Included in front of every source.
SWITCH = """#pragma once
#include <cstdlib>
namespace mutants {
inline const int chosen{std::getenv("STEREOGRID_MUTANT") != nullptr ? std::atoi(std::getenv("STEREOGRID_MUTANT")) : 0};
template <int number> constexpr bool is_chosen() { return chosen == number; }
}
"""


def mutants() -> list:
    lines = LIST.read_text("utf-8").splitlines()
    found = [tuple((line + " ¦ ").split(" ¦ ")[:4]) for line in lines if not line.startswith("#")]
    for file, before, *_ in found:
        if (ROOT / "src" / file).read_text("utf-8").count(before) != 1:
            sys.exit(f"src/{file}: does not have '{before}' once. Correct {LIST.name}.")
    return found


def expression_around(text: str, at: int) -> tuple:
    """Begin and end of the largest expression between brackets, commas and semicolons."""
    begin, end = at, at
    depth = 0
    while depth or not (text[begin - 1] in "({[,;" or re.search(r"(return|[^=<>!]=)\s$", text[begin - 8:begin])):
        begin -= 1
        depth += (text[begin] in ")}]") - (text[begin] in "({[")
    depth = 0
    while depth or text[end] not in ")}],;":
        depth += (text[end] in "({[") - (text[end] in ")}]")
        end += 1
    return begin, end


def switched_text(text: str, changes: list) -> str:
    """The text of a file with all of its changes, each where its number is chosen."""
    places = collections.defaultdict(list)  # expression: number and changed expression
    for number, before, after in changes:
        at = text.index(before) + len(os.path.commonprefix([before, after]))
        begin, end = expression_around(text, at)
        places[begin, end].append((number, text.index(before), before, after))
    outer = {}
    for begin, end in sorted(places, key=lambda place: (place[0], -place[1])):
        around = next((place for place in outer if place[0] <= begin and end <= place[1]), (begin, end))
        outer.setdefault(around, []).extend(places[begin, end])
    for (begin, end), found in sorted(outer.items(), reverse=True):
        switch = f"({text[begin:end]})"
        for number, at, before, after in found:
            changed = (text[:at] + after + text[at + len(before):])[begin:end + len(after) - len(before)]
            switch = f"(mutants::is_chosen<{number}>() ? ({changed}) : {switch})"
        line = text.rfind("\n", 0, begin) + 1
        # a constant would be evaluated at compile time
        head = re.sub(r"(static )?constexpr (?=[\w:<>]+ \w+( = |{))",
                      lambda found: "inline static const " if found[1] else "const ", text[line:begin])
        text = text[:line] + head + switch + text[end:]
    return text


def run(*command, **options) -> bool:
    return subprocess.run(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False,
                          **options).returncode == 0


def write(path: Path, text: str):
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def copy_tree(switched: list):
    """Copies the working tree, with switches in it."""
    names = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout.split("\0")
    changes = collections.defaultdict(list)
    for number, (file, before, after, _) in switched:
        changes[f"src/{file}"].append((number, before, after))
    for name in filter(lambda name: name and (ROOT / name).is_file(), names):
        (TREE / name).parent.mkdir(parents=True, exist_ok=True)
        if name not in changes:
            if not (TREE / name).is_file() or (TREE / name).read_bytes() != (ROOT / name).read_bytes():
                shutil.copyfile(ROOT / name, TREE / name)
            continue
        write(TREE / name, switched_text((ROOT / name).read_text("utf-8"), changes[name]))
    write(WORK / "switch.hpp", SWITCH)


def built() -> bool:
    return run("cmake", "--build", BUILD, "--parallel", 2, "--target", *TESTS)


def passes(test: str, chosen: str, number: int, cpu_s: float) -> bool:
    def limit():
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu_s), int(cpu_s)))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        return run("nice", "-n", 10, BUILD / "bin" / test, "--gtest_fail_fast", "--gtest_brief=1",
                   f"--gtest_filter={chosen}", timeout=WALL_S, preexec_fn=limit, cwd=WORK,
                   env=os.environ | {"STEREOGRID_MUTANT": str(number)})
    except subprocess.TimeoutExpired:
        return False


def cpu_of_tests() -> dict:
    """CPU time of each test program without any change."""
    found = {}
    for test in TESTS:
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if not passes(test, "*", 0, WALL_S):
            sys.exit(f"{test} fails without any change. Mend that first.")
        found[test] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return found


def fate_of(file: str, number: int, cpu_s: dict) -> str:
    slow, chain = FIRST.get(file.split("/")[0], ("Pipeline*", "Chain.*"))
    steps = [(CORE, f"*-{SLOW}"), (CORE, slow), (CHAIN, chain), (CORE, f"{SLOW}-{slow}"), (CHAIN, f"*-{chain}")]
    return "survived" if all(passes(*step, number, 20 + 3 * cpu_s[step[0]]) for step in steps) else "killed"


def fate_of_own_build(file: str, before: str, after: str, cpu_s: dict) -> str:
    path = TREE / "src" / file
    kept = path.read_text("utf-8")
    path.write_text((ROOT / "src" / file).read_text("utf-8").replace(before, after), "utf-8")
    try:
        return fate_of(file, 0, cpu_s) if built() else "broken"
    finally:
        path.write_text(kept, "utf-8")


def print_fates(fates: dict, listed: list):
    """A table by folder, as docs/testing.md has it."""
    columns = ["killed", "survived", "equivalent", "broken", "not run"]
    counts = collections.defaultdict(collections.Counter)
    for file, before, after, note in listed:
        fate = "equivalent" if note == "equivalent" else fates.get(" ¦ ".join([file, before, after]), "not run")
        for row in (file.split("/")[0] if "/" in file else "others", "all"):
            counts[row][fate] += 1
    print("| folder | " + " | ".join(columns) + " |\n" + "|---" * 6 + "|")
    for row in sorted(counts, key=lambda row: (row == "all", row)):
        print(f"| {row} | " + " | ".join(str(counts[row][column]) for column in columns) + " |")
    of = counts["all"]
    print(f"{100 * of['killed'] / max(1, of['killed'] + of['survived']):.0f} % killed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--only", default="", help="changes whose line in the list has this text")
    parser.add_argument("--out", type=Path, default=WORK / "results.txt")
    parser.add_argument("--check", action="store_true", help="only whether each change has its place in src/")
    options = parser.parse_args()
    numbered = list(enumerate(mutants(), 1))
    if options.check:
        return
    WORK.mkdir(parents=True, exist_ok=True)
    fates = {}
    for line in options.out.read_text("utf-8").splitlines() if options.out.exists() else []:
        fate, mutant = line.split(" ¦ ", 1)
        fates[mutant] = fate
    switched = [one for one in numbered if one[1][3] != "alone"]
    copy_tree(switched)
    run("cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG",
        "-DSTEREOGRID_TESTS=ON", "-DSTEREOGRID_HARDENING=OFF", "-DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON",
        f"-DCMAKE_CXX_FLAGS=-include {WORK / 'switch.hpp'} -w -Wno-narrowing")
    if not built():
        sys.exit("The copy in build/mutants/tree does not compile. Give the change that it fails at a build of its own.")
    cpu_s = cpu_of_tests()
    lock = threading.Lock()

    def report(mutant: tuple, fate: str):
        with lock, options.out.open("a", encoding="utf-8") as file:
            file.write(" ¦ ".join([fate, *mutant[:3]]) + "\n")
            fates[" ¦ ".join(mutant[:3])] = fate

    left = [one for one in numbered if " ¦ ".join(one[1][:3]) not in fates and options.only in " ¦ ".join(one[1])]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(lambda one: report(one[1], fate_of(one[1][0], one[0], cpu_s)), [one for one in left if not one[1][3]]))
    for _, mutant in filter(lambda one: one[1][3] == "alone", left):
        report(mutant, fate_of_own_build(*mutant[:3], cpu_s))
    print_fates(fates, mutants())


main()
