#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Frames that a batch could lose, against the program itself: away.py STEREOGRID CASE"""
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from end_to_end import finished, merged, runner, undisturbed
from support import expect_equal, make_plan, scene, status, tool, tool_path


def street_of(folder: Path) -> Path:
    street = folder / "street"
    subprocess.run([tool_path, "-q", "simulate", scene(60).removeprefix("scene:"), "--out", street, "--no-truth"],
                   check=True, stdout=subprocess.DEVNULL)
    return street


def stopped_by(change, plan: Path) -> int:
    """The exit code of a runner whose input `change` alters once three frames more are done."""
    before = finished(plan)
    process = runner(plan, "--shard", 0)
    while process.poll() is None and finished(plan) < before + 3:
        time.sleep(0.005)
    change()
    return process.wait()


def away(folder: Path):
    """An input that is away for a moment loses no frame, and is not given up."""
    street = street_of(folder)
    image = street / "left" / "000050.png"
    whole = image.read_bytes()
    plan = make_plan(folder, street)
    reference = undisturbed(plan)
    assert stopped_by(lambda: street.rename(folder / "elsewhere"), plan) == 75
    found = status(plan)
    assert (found["done"], found["failed"], found["frames_done"]) == (0, 0, 0), found
    # an empty folder where it is mounted later
    street.mkdir()
    assert "mounted" in tool("run", plan, "--shard", 0, expect=75).stderr
    street.rmdir()
    (folder / "elsewhere").rename(street)
    # a folder within it, and a file: restored before the check
    assert stopped_by(lambda: (street / "left").rename(street / "elsewhere"), plan) == 75
    (street / "elsewhere").rename(street / "left")
    assert stopped_by(lambda: image.write_bytes(b""), plan) == 75, "sealed without a frame that was damaged meanwhile"
    assert not list((plan / "results").rglob("done.json")) and status(plan)["failed"] == 0
    image.write_bytes(whole)
    tool("run", plan, "--shard", 0)
    expect_equal(merged(plan), reference)


def skipped(folder: Path):
    """A frame that is damaged when the plan is made is counted by every command."""
    street = street_of(folder)
    image = street / "left" / "000050.png"
    image.write_bytes(image.read_bytes()[:1000])
    lacking = make_plan(folder, street)
    assert "59 frames, 1 of 60 skipped" in tool("run", lacking, "--shard", 0).stdout
    found = status(lacking)
    assert (found["done"], found["frames_done"], found["frames_skipped"], found["frames"]) == (1, 59, 1, 60), found
    assert "59 of 60 frames, 1 skipped" in tool("status", lacking).stdout
    assert "59 of 60 frames merged" in tool("merge", lacking, "--out", folder / "lacking").stdout
    summary = json.loads((folder / "lacking" / "summary.json").read_text(encoding="utf-8"))
    assert (summary["planned"], summary["frames"], summary["skipped"]) == (60, 59, 1), summary


def main():
    with tempfile.TemporaryDirectory(prefix="stereogrid-batch-") as folder:
        {"away": away, "skipped": skipped}[sys.argv[2]](Path(folder).resolve())


if __name__ == "__main__":
    main()
