#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""What `stereogrid batch status` says of runners: watching.py STEREOGRID page|clocks

page: as a page, fetched, and shown by chromium where there is one. clocks: machines whose clocks differ by days.
"""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request
from pathlib import Path

import support
from support import ENVIRONMENT, copy_of, expect_equal, make_plan, scene, skip, status, tool


def get(url: str) -> tuple:
    with urllib.request.urlopen(url, timeout=10) as reply:
        return reply.read().decode(), reply.headers.get_content_type()


def wait_for(what: str, is_so, seconds=60):
    deadline = time.monotonic() + seconds
    while not is_so():
        assert time.monotonic() < deadline, f"{what} did not happen within {seconds} s"
        time.sleep(0.1)


def page(folder: Path):
    plan = make_plan(folder, scene(8), scene(8, 2), "--frames-per-shard", 4, "--warm-up", 1)
    tool("run", plan, "--shard", 1)
    command = [str(support.tool_path), "batch", "status", str(plan), "--watch", "0"]
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True)
    try:
        url = process.stdout.readline().split()[-1]
        html, kind = get(url)
        assert kind == "text/html" and "batch.js" in html, html
        assert get(url + "batch.js")[1] == "text/javascript"
        answer = json.loads(get(url + "status.json")[0])
        assert answer["status"] == status(plan) and answer["plan"] == str(plan), answer
        assert (answer["status"]["done"], answer["status"]["missing"]) == (1, 3)
        if shutil.which("chromium"):
            check_shown(url, folder)
        else:
            print("not shown: there is no chromium")
        tool("run", plan, "--shard", "0,2")
        wait_for("a new look", lambda: json.loads(get(url + "status.json")[0])["status"] == status(plan))
        (plan / "manifest.jsonl").rename(plan / "elsewhere")
        wait_for("a complaint", lambda: "manifest.jsonl" in json.loads(get(url + "status.json")[0])["fault"])
        (plan / "elsewhere").rename(plan / "manifest.jsonl")
        wait_for("a new look", lambda: json.loads(get(url + "status.json")[0])["fault"] == "")
        taken = tool("status", plan, "--watch", url.rstrip("/").split("//")[1], expect=75).stderr
        assert "--watch :0 takes any free port" in taken, taken
    finally:
        process.terminate()
        assert process.wait(timeout=20) == 0
    for words in (["--watch", "0", "--json"], ["--watch", "port"], ["--watch", "70000"]):
        tool("status", plan, *words, expect=64)


def check_shown(url: str, folder: Path):
    """What a reader sees, after the script has run."""
    done = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'browser'}",
                           "--virtual-time-budget=5000", "--dump-dom", url], capture_output=True, text=True, check=True,
                          timeout=60)
    for text in ('>1</td><td class="number">25.0 %<', '>3</td><td class="number">75.0 %<', ">4 of 16<", "None."):
        assert text in done.stdout, f"{text} is not on the page:\n{done.stdout}"


def runs_as(plan: Path, states: list):
    """What status says, by the right clock and by others."""
    found = [status(plan)]
    for clock in ("+3d", "-3d"):
        command = ["faketime", "-f", clock, str(support.tool_path), "batch", "status", str(plan), "--json"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=ENVIRONMENT | {"NO_FAKE_STAT": "1"})
        found.append(json.loads(done.stdout))
    counts = [[one[key] for key in ("running", "stopped", "missing", "done")] for one in found]
    assert counts == [states] * 3, counts


def end(wrapper: subprocess.Popen):
    """Ends what faketime has started, and waits for it: a signal to faketime itself would leave it at work."""
    children = Path(f"/proc/{wrapper.pid}/task/{wrapper.pid}/children").read_text(encoding="ascii").split()
    for pid in map(int, children or [wrapper.pid]):
        os.kill(pid, signal.SIGTERM)
    wrapper.wait(timeout=60)


def clocks(folder: Path):
    """Runners and who asks for them have clocks that differ by days; files' times are of the file system's."""
    if not shutil.which("faketime"):
        skip("there is no faketime")
    plan = make_plan(folder, scene(600), "--frames-per-shard", 300, "--warm-up", 5)
    small = make_plan(folder / "small", scene(6), "--frames-per-shard", 3, "--warm-up", 2)
    runs_as(plan, [0, 0, 2, 0])
    for clock in ("+2d", "-2d"):
        command = ["faketime", "-f", clock, str(support.tool_path), "batch", "run", str(plan), "--shard", "0"]
        process = subprocess.Popen(command, env=ENVIRONMENT | {"NO_FAKE_STAT": "1"}, stderr=subprocess.DEVNULL)
        alive = lambda: next((plan / "work").rglob("alive"), None) if (plan / "work").exists() else None
        wait_for("a heartbeat", lambda: alive() and next((plan / "work").rglob("frames.jsonl"), None))
        runs_as(plan, [1, 0, 1, 0])
        end(process)
        # long ago, or (of a file system that takes the times of its clients) to come: neither is a sign of life
        for seconds in (-1000, 1000):
            os.utime(alive(), (time.time() + seconds,) * 2)
            runs_as(plan, [0, 1, 1, 0])
        shutil.rmtree(plan / "work")
    reference = copy_of(small, "reference")
    tool("run", reference, "--all")
    for clock, shard in (("+2d", "0"), ("-2d", "1")):
        subprocess.run(["faketime", "-f", clock, str(support.tool_path), "batch", "run", str(small), "--shard", shard],
                       check=True, env=ENVIRONMENT | {"NO_FAKE_STAT": "1"}, stdout=subprocess.DEVNULL)
    for one in (small, reference):
        tool("merge", one, "--out", Path(f"{one}-merged"), "--runs")
    expect_equal(Path(f"{small}-merged"), Path(f"{reference}-merged"))


def main():
    with tempfile.TemporaryDirectory(prefix="stereogrid-watching-") as name:
        folder = Path(name).resolve()
        (folder / "small").mkdir()
        {"page": page, "clocks": clocks}[sys.argv[2]](folder)


if __name__ == "__main__":
    main()
