# SPDX-License-Identifier: Apache-2.0
"""Joins the ranges of a run, scores it, and merges the scores of all runs: jobs of the Snakefile beside this file.

join.py SCORES [--no-evaluation] [--place FOLDER] --tool TOOL --ranges DONE... --settings KEY=VALUE...

makes FOLDER/runs/NAME of FOLDER/parts/NAME/RANGE, with hard links to their files, and scores/NAME.json (docs/fleet.md).
"""
import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from statistics import fmean, stdev

IMPOSSIBLE = (64, 65)
NORMAL_95 = 1.96
OF_A_MACHINE = ("frames.jsonl", "run.json")  # contain times


def join_descriptions(parts: "list[dict]") -> dict:
    """run.json of the whole run; times of stages are left out where there are several parts."""
    whole = dict(parts[-1], frames=dict(parts[-1]["frames"], first=parts[0]["frames"]["first"]), warm_up=parts[0]["warm_up"])
    for key in ("done", "skipped"):
        whole["frames"][key] = sum(part["frames"][key] for part in parts)
    whole["skipped"] = [frame for part in parts for frame in part["skipped"]]
    whole["status"] = dict(sum((Counter(part["status"]) for part in parts), Counter()))
    warnings = Counter()
    for part in parts:
        warnings.update({warning["text"]: warning["frames"] for warning in part["warnings"]})
    whole["warnings"] = [{"text": text, "frames": frames} for text, frames in sorted(warnings.items())]
    if len(parts) > 1:
        whole.pop("timing_ms", None)
    return whole


def sums_of(run: Path) -> "dict[str, str]":
    """Name and SHA-256 of each file."""
    files = sorted(file for file in run.rglob("*") if file.is_file() and file.name != "SHA256SUMS")
    return {str(file.relative_to(run)): hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def digest(value) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def join_run(parts: "list[Path]", run: Path) -> dict:
    """Links the files of all parts. Returns the description of the run."""
    shutil.rmtree(run, ignore_errors=True)
    run.mkdir(parents=True)
    for part in parts:
        for file in part.glob("*/*"):
            link = run / file.relative_to(part)
            link.parent.mkdir(exist_ok=True)
            os.link(file, link)
    with open(run / "frames.jsonl", "wb") as lines:
        for part in parts:
            lines.write((part / "frames.jsonl").read_bytes())
    description = join_descriptions([json.loads((part / "run.json").read_bytes()) for part in parts])
    (run / "run.json").write_text(json.dumps(description, indent=1) + "\n", encoding="utf-8")
    return description


def evaluate(tool: str, run: Path) -> dict:
    """Scores, or why there are none."""
    file = run.with_name(run.name + ".json")
    done = subprocess.run([tool, "-q", "evaluate", run, "--json", file], check=False, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True, errors="replace")
    print(done.stderr, end="", file=sys.stderr)
    if done.returncode in IMPOSSIBLE:
        return {"not_scored": done.stderr.strip()}
    if done.returncode:
        sys.exit(done.returncode if done.returncode > 0 else 128 - done.returncode)
    scores = json.loads(file.read_bytes())
    file.unlink()
    return {"scores": scores}


def join(scores: Path, ranges: "list[Path]", settings: "list[str]", tool: str, is_evaluated: bool = True, place: str = ".") -> None:
    name = scores.name.removesuffix(".json")
    # code, options, message
    said = {done.name: done.read_text(encoding="utf-8").split("\n", 2) for done in ranges}
    parts = [Path(place, "parts", name, one) for one, (code, _, _) in said.items() if code == "0"]
    result = {"settings": settings, "ranges": {one: options for one, (_, options, _) in said.items()}, "frames": 0, "skipped": 0,
              "version": "", "impossible": {one: f"{code} {message}".strip() for one, (code, _, message) in said.items() if code != "0"}}
    if parts:
        run, new = Path(place, "runs", name), Path(place, "runs", name + ".new")
        description = join_run(parts, new)
        result.update(frames=description["frames"]["done"], skipped=description["frames"]["skipped"],
                      version=description["version"])
        if is_evaluated:
            result.update(evaluate(tool, new))
        sums = sums_of(new)
        result["digest"] = digest({file: value for file, value in sums.items() if file not in OF_A_MACHINE})
        (new / "SHA256SUMS").write_text("".join(f"{value}  {file}\n" for file, value in sums.items()), encoding="utf-8")
        shutil.rmtree(run, ignore_errors=True)
        new.rename(run)
    new = scores.with_name(scores.name + ".new")
    new.write_text(json.dumps(result, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    new.rename(scores)


def figures_of(scores, prefix: str = "") -> "dict[str, float]":
    """All numbers of `evaluate --json` but those of single frames, by their place."""
    figures = {}
    for key, value in scores.items():
        if isinstance(value, dict) and isinstance(value.get("value"), (int, float)):
            value = value["value"]
        if isinstance(value, dict):
            figures.update(figures_of(value, f"{prefix}{key}."))
        elif isinstance(value, (int, float)):
            figures[prefix + key] = value
    return figures


def over_drives(drives: "list[dict]") -> dict:
    """Means, each drive counts once, with the half of their 95 % intervals over drives (None: one drive)."""
    result = {}
    for name in sorted(set().union(*drives)):
        values = [drive[name] for drive in drives if name in drive]
        half = NORMAL_95 * stdev(values) / len(values)**0.5 if len(values) > 1 else None
        result[name] = {"mean": fmean(values), "half_interval": half, "drives": len(values)}
    return result


def read(file: str) -> dict:
    return json.loads(Path(file).read_bytes())


def refuse_mixed(runs: "dict[str, dict]", ranges: "dict[str, dict[str, str]]") -> None:
    """Exits where a run has other ranges or options than `ranges`, or another version than most."""
    version = Counter(run["version"] for run in runs.values() if run["version"]).most_common(1)
    usual = version[0][0] if version else ""
    other = [name for name, run in runs.items() if run["ranges"] != ranges[name] or run["version"] not in ("", usual)]
    if other:
        sys.exit(f"Made with another version or other options: {' '.join(other)}. Remove their files in done/, parts/ and "
                 "scores/, then start again.")


def summary_of(runs: "dict[str, dict]") -> dict:
    scored = [figures_of({key: run["scores"][key] for key in ("series", "obstacles") if key in run["scores"]})
              for run in runs.values() if "scores" in run]
    return {"drives": len(runs),
            "frames": sum(run["frames"] for run in runs.values()),
            "skipped": sum(run["skipped"] for run in runs.values()),
            "impossible": sorted(name for name, run in runs.items() if run["impossible"]),
            "not_scored": sorted(name for name, run in runs.items() if "scores" not in run),
            "figures": over_drives(scored)}


def merge(files: "list[str]", ranges: "dict[str, dict[str, str]]", out: str) -> None:
    """Writes bytes that do not depend on the machines and times of the runs. `ranges`: those of each run, with their options."""
    runs = {Path(file).stem: read(file) for file in files}
    refuse_mixed(runs, ranges)
    variants = {}
    for name, run in runs.items():
        variants.setdefault(", ".join(run["settings"]), {})[name] = run
    summary = {settings: summary_of(those) for settings, those in variants.items()}
    new = Path(out + ".new")
    new.write_text(json.dumps(summary, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    new.rename(out)
    for settings, one in summary.items():
        print(f"{settings or 'all'}: {one['drives']} drives, {one['frames']} frames, {one['skipped']} skipped, "
              f"{len(one['impossible'])} impossible", file=sys.stderr)


def check(files: "list[str]", place: str = ".") -> None:
    """Exits where a file of a run is missing or differs from its digest."""
    wrong = []
    for file in files:
        run = Path(place, "runs", Path(file).stem)
        if "digest" in read(file) and (not run.exists() or subprocess.run(
                ["sha256sum", "--check", "--quiet", "--strict", "SHA256SUMS"], cwd=run, check=False).returncode):
            wrong.append(str(run))
    if wrong:
        sys.exit(f"These runs are damaged: {' '.join(wrong)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scores", type=Path)
    parser.add_argument("--no-evaluation", action="store_true")
    parser.add_argument("--place", default=".")
    parser.add_argument("--tool", required=True)
    parser.add_argument("--ranges", type=Path, nargs="+", required=True)
    parser.add_argument("--settings", nargs="*", default=[])
    options = parser.parse_args()
    join(options.scores, options.ranges, options.settings, options.tool, not options.no_evaluation, options.place)


if __name__ == "__main__":
    main()
