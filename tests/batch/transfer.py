#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Inputs that are fetched and results that are pushed: transfer.py STEREOGRID

A folder plays the object store, a shell script what copies: one that fails, delivers damaged data, hangs, or does not
end. Planned is with the drives in place; then they are only in the store.
"""
import json
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import support
from support import ENVIRONMENT, copy_of, drive, expect_equal, make_plan, status, tool

# Its first words are what it does the first times, one each; then it copies.
COPY = """#!/bin/sh
echo "$2 to $3" >> "$CALLS"
calls=$(wc -l < "$CALLS")
what=$(echo "$1" | cut -d , -f "$calls")
case "$what" in
  fail) echo "no such bucket" >&2; exit 3 ;;
  hang) sleep 71717; exit 0 ;;
  fill) while :; do head -c 1000000 /dev/zero >> "$3/more"; sleep 0.01; done ;;
esac
mkdir -p "$3" && cp -R "$2/." "$3" || exit 1
[ "$what" != damage ] || rm "$3/left/000001.png"
"""


class Place:
    """A plan whose drives are in the store only, and a folder for what is fetched."""

    def __init__(self, folder: Path, *words):
        self.folder = folder
        self.near, self.store, self.scratch = folder / "near", folder / "store", folder / "scratch"
        self.near.mkdir()
        # a name that a shell would take apart
        drive(self.near / "drive; 'one' $x", 1)
        drive(self.near / "two", 2)
        self.copy = folder / "copy.sh"
        self.copy.write_text(COPY, encoding="utf-8")
        self.plan = make_plan(folder, *sorted(self.near.iterdir()), "--frames-per-shard", 2, "--warm-up", 1, *words)
        self.reference = copy_of(self.plan, "reference")
        tool("run", self.reference, "--all")
        self.merged = self.merge(self.reference)
        self.near.rename(self.store)

    def merge(self, plan: Path) -> Path:
        out = Path(f"{plan}-merged")
        tool("merge", plan, "--out", out, "--runs")
        return out

    def words(self, behaviour: str, *more) -> list:
        return ["--uri", f"{self.near}={self.store}", "--fetch", f"sh '{self.copy}' '{behaviour},' {{uri}} {{dir}}",
                "--scratch", self.scratch, *more]

    def environment(self, name: str) -> dict:
        return {"env": ENVIRONMENT | {"CALLS": str(self.folder / f"{name}.calls")}}

    def calls(self, name: str) -> int:
        file = self.folder / f"{name}.calls"
        return len(file.read_text(encoding="utf-8").splitlines()) if file.exists() else 0

    def expect_clean(self):
        left = [path.name for path in self.scratch.iterdir() if not path.name.startswith(".")]
        assert not left, f"left in the scratch folder: {left}"


def fetched(place: Place):
    """Fails twice, delivers damaged data once, then works: the results are those of inputs that were in place."""
    plan = copy_of(place.plan, "fetched")
    assert "mounted" in tool("run", plan, "--all", expect=75).stderr
    done = tool("run", plan, "--all", *place.words("fail,fail,damage"), **place.environment("fetched"))
    for text in ("exit code 3", "another checksum", "trying again"):
        assert text in done.stderr, done.stderr
    assert place.calls("fetched") == 5, "each drive once, not each shard, but for what failed"
    expect_equal(place.merge(plan), place.merged)
    place.expect_clean()


def not_fetched(place: Place):
    """After the last try: 75, nothing recorded as impossible, nothing left; the next one does it."""
    plan = copy_of(place.plan, "later")
    said = tool("run", plan, "--shard", 0, *place.words("fail,damage,fail", "--retries", 1),
                **place.environment("later"), expect=75).stderr
    assert "the input was not fetched" in said and "another checksum" in said, said
    assert status(plan)["failed"] == 0
    place.expect_clean()
    tool("run", plan, "--all", *place.words("fail,damage,fail", "--retries", 1), **place.environment("later"))
    expect_equal(place.merge(plan), place.merged)
    plan = copy_of(place.plan, "nothing")
    said = tool("run", plan, "--shard", 0, "--uri", f"{place.near}=x", "--fetch", "no-such-program {uri} {dir}",
                "--retries", 0, expect=75).stderr
    assert "no-such-program cannot be started" in said, said


def children() -> str:
    return subprocess.run(["pgrep", "-f", "sleep 71717"], capture_output=True, text=True, check=False).stdout


def hangs(place: Place):
    plan = copy_of(place.plan, "hangs")
    start = time.monotonic()
    words = place.words("hang", "--retries", 1, "--transfer-timeout", 1)
    done = tool("run", plan, "--shard", 0, *words, **place.environment("hangs"))
    assert "took longer than 1 s" in done.stderr, done.stderr
    assert time.monotonic() - start < 60
    assert not children(), "what the command has started goes on"


def stopped(place: Place):
    """SIGTERM ends the command and clears up; after SIGKILL the next runner does."""
    for how, name in ((signal.SIGTERM, "stopped"), (signal.SIGKILL, "killed")):
        plan = copy_of(place.plan, name)
        words = ["run", plan, "--all", *place.words("hang")]
        environment = place.environment(name)
        process = subprocess.Popen([str(support.tool_path), "batch", *map(str, words)], **environment,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while place.calls(name) == 0 and process.poll() is None:
            time.sleep(0.01)
        process.send_signal(how)
        code = process.wait(timeout=30)
        if how == signal.SIGTERM:
            assert code == 75, code
            assert not children(), "what the command has started goes on"
        else:
            left = [path.name for path in place.scratch.iterdir() if not path.name.startswith(".")]
            assert len(left) == 1, "the test wants something to be cleared up"
            subprocess.run(["pkill", "-f", "sleep 71717"], check=False)
        if how == signal.SIGTERM:
            place.expect_clean()
        tool(*words, **environment)
        place.expect_clean()
        expect_equal(place.merge(plan), place.merged)


def full(place: Place):
    plan = copy_of(place.plan, "full")
    done = tool("run", plan, "--shard", 0, *place.words("fill", "--scratch-limit", "3M"), **place.environment("full"),
                expect=75)
    assert "holds more than 3M" in done.stderr, done.stderr
    assert place.calls("full") == 1, "what is too large is not fetched again at once"
    place.expect_clean()
    assert status(plan)["failed"] == 0


def poison(place: Place):
    """Bad data with the right checksum: recorded, in the words of an input that lies where the plan says."""
    image = place.store / "two" / "left"
    kept = {file: file.read_bytes() for file in image.iterdir()}
    for file, content in kept.items():
        file.write_bytes(b"x" * len(content))
    plan = copy_of(place.plan, "poison")
    said = tool("run", plan, "--shard", 2, *place.words(""), **place.environment("poison"), expect=65).stderr
    assert str(place.near / "two") in said and str(place.scratch) not in said, said
    assert status(plan)["failed"] == 1
    place.expect_clean()
    for file, content in kept.items():
        file.write_bytes(content)


def some_frames(place: Place):
    """Frames that are skipped are told of as of an input that lies where the plan says."""
    image = place.store / "two" / "left" / "000003.png"
    kept = image.read_bytes()
    image.write_bytes(b"x" * len(kept))
    plan = copy_of(place.plan, "some")
    tool("run", plan, "--shard", "2-3", *place.words(""), **place.environment("some"))
    runs = [json.loads(file.read_text(encoding="utf-8")) for file in plan.glob("results/*/*/run.json")]
    reasons = [frame["reason"] for run in runs for frame in run["skipped"]]
    assert len(reasons) == 1 and reasons[0].startswith(str(place.near / "two" / "left" / "000003.png")), reasons
    assert all(str(place.scratch) not in json.dumps(run) for run in runs)
    image.write_bytes(kept)


def pushed(place: Place):
    """Results go elsewhere once; where that fails they are done, but the exit code asks for another try."""
    plan = copy_of(place.plan, "pushed")
    target = place.folder / "target"
    push = f"sh '{place.copy}' fail,fail, {{dir}} {target}/{{drive}}/{{shard}}/{{result}}"
    words = ["run", plan, "--all", *place.words(""), "--push", push]
    environment = {"env": ENVIRONMENT | {"CALLS": str(place.folder / "push.calls")}}
    tool("run", plan, "--all", *place.words(""), **place.environment("other"))
    said = tool(*words, "--retries", 0, **environment, expect=75).stderr
    assert "the result was not pushed" in said, said
    assert status(plan)["done"] == 4
    tool(*words, **environment)
    count = place.calls("push")
    results = sorted(file.parent for file in target.rglob("done.json"))
    assert len(results) == 4, results
    for result in results:
        name = result.relative_to(target / result.relative_to(target).parts[0] / result.relative_to(target).parts[1])
        expect_equal(result, plan / "results" / name)
    tool(*words, **environment)
    assert place.calls("push") == count, "what was pushed is not pushed again"


def recorded(folder: Path):
    """What the plan says of fetching holds for every runner, and may be overruled."""
    near = folder / "near"
    drive(near / "one", 1)
    copy = folder / "copy.sh"
    copy.write_text(COPY, encoding="utf-8")
    common = [near / "one", "--uri", f"{near}={folder / 'store'}"]
    for words, expected in ((["--fetch", "cp {uri}"], "{dir} is missing"), (["--fetch", "cp {uri} {dir} {where}"], "{where}"),
                            (["--fetch", "cp '{uri} {dir}"], "quotation mark"), (["--scratch-limit", "much"], "no size"),
                            (["--push", "cp {uri}"], "{dir} is missing")):
        said = tool("plan", *common, *words, "--out", folder / "plan", expect=64).stderr
        assert expected in said, said
    assert "--uri" in tool("plan", near / "one", "--fetch", "cp {uri} {dir}", "--out", folder / "plan", expect=64).stderr
    said = tool("plan", near / "one", "--uri", "near=x", "--out", folder / "plan", expect=64).stderr
    assert "absolute path" in said, said
    # what would not come with the drive
    calibration = near / "one" / "calibration.yaml"
    text = calibration.read_text(encoding="utf-8")
    calibration.write_text(text + "mask: ../mask.png\n", encoding="utf-8")
    shutil.copy(near / "one" / "left" / "000000.png", near / "mask.png")
    said = tool("plan", *common, "--out", folder / "plan", expect=65).stderr
    assert "lies outside of it" in said, said
    calibration.write_text(text, encoding="utf-8")
    shutil.rmtree(folder / "plan")
    plan = make_plan(folder, *common, "--fetch", f"sh {copy} fail, {{uri}} {{dir}}", "--scratch", folder / "scratch")
    near.rename(folder / "store")
    environment = {"env": ENVIRONMENT | {"CALLS": str(folder / "calls")}}
    tool("run", plan, "--all", "--retries", 0, **environment, expect=75)
    tool("run", plan, "--all", "--retries", 0, **environment)
    assert status(plan)["done"] == 1


def main():
    with tempfile.TemporaryDirectory(prefix="stereogrid-transfer-") as name:
        folder = Path(name).resolve()
        (folder / "place").mkdir()
        place = Place(folder / "place")
        for case in (fetched, not_fetched, hangs, stopped, full, poison, some_frames, pushed):
            print(case.__name__, flush=True)
            case(place)
        (folder / "recorded").mkdir()
        recorded(folder / "recorded")


if __name__ == "__main__":
    main()
