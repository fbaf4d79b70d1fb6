# SPDX-License-Identifier: Apache-2.0
"""Shared parts of the tests of fleets. The program is the first word of the command line."""
import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

TOOL = Path(sys.argv[1]).resolve()
FLEET = Path(__file__).resolve().parents[2] / "packaging" / "fleet"
SIZE = "&width=160&height=100"


def skip(why: str):
    print(f"SKIPPED: {why}")
    sys.exit(77)


def require_snakemake() -> str:
    if not shutil.which("snakemake"):
        skip("Snakemake is not installed")
    return "snakemake"


def simulate(folder: Path, frames: int, seed: int = 1) -> Path:
    subprocess.run([TOOL, "-q", "simulate", f"street?frames={frames}&seed={seed}{SIZE}", "--out", folder], check=True,
                   stdout=subprocess.DEVNULL)
    return folder


def configure(folder: Path, drives: dict, **others) -> Path:
    """Writes fleet.yaml; JSON is YAML, too."""
    text = json.dumps({"tool": str(TOOL), "pause_s": 0.2, "retries": 20, "drives": drives, **others})
    (folder / "fleet.yaml").write_text(text, encoding="utf-8")
    return folder / "fleet.yaml"


def command_of(config: Path, results: Path, *words, profile: str = "local") -> list:
    return ["snakemake", "--snakefile", FLEET / "Snakefile", "--profile", FLEET / profile, "--configfile", config, "--directory",
            results, *words]


def finish(config: Path, results: Path, *words, expect: int = 0) -> str:
    done = subprocess.run(command_of(config, results, *words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          errors="replace", check=False)
    assert done.returncode == expect, done.stdout
    return done.stdout


def without_times(line: str) -> str:
    frame = json.loads(line)
    del frame["timing_ms"]
    return json.dumps(frame)


def contents(results: Path) -> dict:
    """Digests of all results but times."""
    found = {"summary.json": (results / "summary.json").read_text(encoding="utf-8")}
    for file in sorted((results / "runs").rglob("*")):
        if file.suffix == ".npz":
            found[str(file.relative_to(results))] = hashlib.sha256(file.read_bytes()).hexdigest()
        elif file.suffix == ".jsonl":
            found[str(file.relative_to(results))] = [without_times(line) for line in file.read_text(encoding="utf-8").splitlines()]
    return found


def expect_equal(a: Path, b: Path):
    one, other = contents(a), contents(b)
    assert one.keys() == other.keys(), f"other files: {one.keys() ^ other.keys()}"
    different = [name for name, content in one.items() if content != other[name]]
    assert not different, f"these differ: {different}"
    print(f"{len(one)} files are equal")
