#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Jobs of fleets without Snakemake: jobs.py STEREOGRID CASE"""
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from support import FLEET, SIZE, TOOL, simulate

sys.path.insert(0, str(FLEET))
import join  # noqa: E402


def call(command: list, expect: int = 0) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == expect, f"{command}: {done.returncode}, not {expect}\n{done.stderr}"
    return done.stderr


def list_files(drive, name: str = "drive", expect: int = 0):
    Path("files").mkdir(exist_ok=True)
    call([sys.executable, FLEET / "job.py", "files", Path("files") / name, "--", drive], expect)


def range_command(done, drive, name: str, *words, tool=TOOL) -> list:
    job = [FLEET / "job.py", "range", done, "files/drive", "--pause", "0.01", "--options=words", "--"]
    run = [tool, "-q", "run", drive, "--out", f"parts/drive/{name}", "--resume", "--checkpoint-every", "4", "--threads", "1"]
    return [sys.executable, *map(str, [*job, *run, *words])]


def process(drive, name: str = "all", *words, expect=0, tool=TOOL) -> str:
    """A range. Returns the messages; done/drive/NAME is there where it ends with 0."""
    done = Path("done/drive") / name
    done.parent.mkdir(parents=True, exist_ok=True)
    done.unlink(missing_ok=True)
    said = call(range_command(done, drive, name, *words, tool=tool), expect)
    assert done.exists() == (expect == 0)
    return said


def recorded(name: str = "all") -> str:
    return (Path("done/drive") / name).read_text(encoding="utf-8")


def stub(code: int, once: bool = False) -> Path:
    """A program that ends with the code, or does so once and then is the real one; lines of `calls` count its calls."""
    again = f'[ "$(wc -l <calls)" -gt 1 ] && exec {TOOL} "$@"' if once else ""
    Path("calls").unlink(missing_ok=True)
    Path("stub").write_text(f'#!/bin/sh\necho >>calls\n{again}\necho "a reason" >&2\nexit {code}\n', encoding="utf-8")
    Path("stub").chmod(0o755)
    return Path("stub").resolve()


def codes():
    """64 and 65, said twice, are recorded; all others are the job's own."""
    drive = simulate(Path("drive"), 3)
    list_files(drive)
    for code in (64, 65):
        process(drive, tool=stub(code))
        assert recorded() == f"{code}\nwords\na reason\n", recorded()
        assert Path("calls").read_text() == "\n\n"
    for code in (1, 70, 75, 130, 137, 143):
        process(drive, expect=code, tool=stub(code))
    killed = stub(0)
    killed.write_text("#!/bin/sh\nkill -9 $$\n", encoding="utf-8")
    process(drive, expect=137, tool=killed)
    process(drive, tool=stub(65, once=True))
    assert recorded() == "0\nwords\n", recorded()
    for image in (drive / "left").iterdir():
        image.write_bytes(b"x" * image.stat().st_size)
    process(drive, "bad")
    assert recorded("bad").startswith("65\n") and "none of the left images" in recorded("bad")


def signals():
    """SIGTERM reaches the program, which saves its state; the next job continues."""
    drive = f"scene:street?frames=40{SIZE}"
    list_files(drive)
    process(drive)
    whole = join.sums_of(Path("parts/drive/all/grids"))
    shutil.rmtree("parts")
    command = range_command("done/drive/stopped", drive, "stopped")
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as running:
        part = Path("parts/drive/stopped")
        while running.poll() is None and len(list((part / "grids").glob("*.npz"))) < 6:
            time.sleep(0.01)
        running.terminate()
    assert running.returncode == 143, running.returncode
    assert (part / "state.npz").exists() and len(list((part / "grids").glob("*.npz"))) < 40
    process(drive, "stopped")
    assert join.sums_of(part / "grids") == whole


def away():
    """An input that is away as a whole or in part, or that differs from its list: 75, and nothing is recorded."""
    drive = simulate(Path("drive"), 8)
    list_files(drive)
    process(drive)
    whole = join.sums_of(Path("parts/drive/all/grids"))
    shutil.rmtree("parts")
    drive.rename("elsewhere")
    assert "Mount its" in process(drive, expect=75)
    drive.mkdir()
    assert "Mount its" in process(drive, expect=75)
    list_files(drive, "other", expect=75)
    drive.rmdir()
    Path("elsewhere").rename(drive)
    image = drive / "left" / "000005.png"
    content = image.read_bytes()
    for change, restore in ((f"mv {image} image", f"mv image {image}"), ("mv drive/left left", "mv left drive/left"),
                            (f"echo >>{image}", "true")):
        # files are listed before and after the program, which changes them itself here
        unlucky = stub(0)
        unlucky.write_text(f'#!/bin/sh\n{change}\nexec {TOOL} "$@"\n', encoding="utf-8")
        assert "was away" in process(drive, expect=75, tool=unlucky)
        assert "differs" in process(drive, expect=75)
        subprocess.run(restore, shell=True, check=True)
        image.write_bytes(content)
    process(drive)
    assert join.sums_of(Path("parts/drive/all/grids")) == whole


def damaged():
    """A part that a machine has left damaged is thrown away."""
    drive = simulate(Path("drive"), 8)
    list_files(drive)
    process(drive)
    whole = join.sums_of(Path("parts/drive/all/grids"))
    grid = Path("parts/drive/all/grids/000002.npz")
    for content in (b"", bytes(len(grid.read_bytes())), grid.read_bytes()[:-1]):
        grid.write_bytes(content)
        assert "damaged" in process(drive, expect=75)
        process(drive)
        assert join.sums_of(grid.parent) == whole
    Path("parts/drive/all/run.json").write_text("{", encoding="utf-8")
    process(drive)
    assert join.sums_of(grid.parent) == whole


def cut():
    """Joined ranges: one world, one line for each frame, scores of the whole; an exact warm-up gives the same bytes."""
    drive = f"scene:street?frames=12{SIZE}"
    list_files(drive)
    process(drive)
    whole = Path("parts/drive/all")
    for name, warm_up in (("0-4", 0), ("5-", 5)):
        process(drive, name, "--frames", name.replace("-", ":"), "--warm-up", warm_up)
    Path("scores").mkdir()
    join.join(Path("scores/drive.json"), [Path("done/drive/0-4"), Path("done/drive/5-")], [], str(TOOL))
    run = Path("runs/drive")
    assert join.sums_of(run / "grids") == join.sums_of(whole / "grids")
    lines = [[json.loads(line) for line in (folder / "frames.jsonl").read_text().splitlines()] for folder in (whole, run)]
    for one, other in zip(*lines, strict=True):
        for key in ("x_m", "y_m", "yaw_rad"):
            assert abs(one["pose"][key] - other["pose"][key]) < 1e-9, (one["pose"], other["pose"])
    assert json.loads((run / "run.json").read_text())["frames"] == json.loads((whole / "run.json").read_text())["frames"]
    subprocess.run([TOOL, "-q", "evaluate", whole, "--json", "whole.json"], check=True, stdout=subprocess.DEVNULL)
    scores, expected = json.loads(Path("scores/drive.json").read_text()), json.loads(Path("whole.json").read_text())
    assert (scores["frames"], scores["skipped"], scores["impossible"]) == (12, 0, {}), scores
    for key in ("series", "obstacles"):
        assert scores["scores"][key] == expected[key], key
    join.check(["scores/drive.json"])
    grid = run / "grids" / "000003.npz"
    grid.unlink()  # a hard link
    grid.write_bytes(b"x")
    try:
        join.check(["scores/drive.json"])
    except SystemExit:
        return
    raise AssertionError("a damaged file is not noticed")


def main():
    with tempfile.TemporaryDirectory(prefix="stereogrid-fleet-") as folder:
        os.chdir(folder)
        {"codes": codes, "signals": signals, "away": away, "damaged": damaged, "cut": cut}[sys.argv[2]]()


if __name__ == "__main__":
    main()
