#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""What planning, looking at and merging many shards costs, as Markdown: fleet.py STEREOGRID SHARDS [FOLDER]

A plan of one endless scene, a frame a shard; the results are not worked out but made up: timing.json and done.json of a
shard that was. The least of three for status, once for plan and merge. FOLDER: where to work, on the file system that
is to be measured.
"""
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def measured(*words) -> tuple:
    """Seconds, and the most memory in MB."""
    start = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{words}: exit code {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - start, usage.ru_maxrss / 1000


def make_up_results(plan: Path, tool: str) -> None:
    subprocess.run([tool, "-q", "batch", "run", plan, "--shard", "0"], check=True)
    real = next(plan.glob("results/*/*"))
    timing = (real / "timing.json").read_bytes()
    done = json.loads((real / "done.json").read_text(encoding="utf-8"))
    done["content"] = hashlib.sha256(b"").hexdigest()
    done["files"] = [["timing.json", len(timing), hashlib.sha256(timing).hexdigest()]]
    shutil.rmtree(real)
    with open(plan / "manifest.jsonl", encoding="utf-8") as lines:
        for line in lines:
            digest = json.loads(line)["digest"]
            folder = plan / "results" / digest[:3] / digest[:16]
            os.makedirs(folder)
            (folder / "timing.json").write_bytes(timing)
            (folder / "done.json").write_text(json.dumps(done | {"digest": digest}), encoding="utf-8")


def main():
    tool, shards = sys.argv[1], int(sys.argv[2])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory(dir=sys.argv[3] if len(sys.argv) > 3 else None) as name:
        plan = Path(name) / "plan"
        scene = f"scene:street?frames={shards}&width=64&height=48"
        rows = [("plan", *measured(tool, "-q", "batch", "plan", scene, "--frames-per-shard", "1", "--warm-up", "0",
                                   "--no-evaluation", "--out", str(plan)))]
        rows.append(("status, nothing done", *min(measured(tool, "batch", "status", str(plan)) for _ in range(3))))
        make_up_results(plan, tool)
        rows.append(("status, all done", *min(measured(tool, "batch", "status", str(plan)) for _ in range(3))))
        rows.append(("merge", *measured(tool, "-q", "batch", "merge", str(plan), "--out", str(Path(name) / "merged"))))
        manifest = (plan / "manifest.jsonl").stat().st_size / shards
    print("| what | shards | s | µs a shard | memory, MB |\n| --- | --- | --- | --- | --- |")
    for what, seconds, memory in rows:
        print(f"| {what} | {shards} | {seconds:.1f} | {1e6 * seconds / shards:.0f} | {memory:.0f} |")
    print(f"\n* The manifest has {manifest:.0f} bytes a shard.")


if __name__ == "__main__":
    main()
