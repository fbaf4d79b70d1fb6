# SPDX-License-Identifier: Apache-2.0
"""run() and RunWriter: exclusive folders, stopped runs that continue, fusion. The results are those of the tool."""

from __future__ import annotations

import io
import json
import os
import signal
import sys
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
from conftest import check_same_grids, pipeline_of, write_run

import stereogrid as sg


def lines_of(run: Path) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in (run / "frames.jsonl").read_text().splitlines()]
    return [{key: value for key, value in line.items() if key != "timing_ms"} for line in lines]


def check_equal(run: Path, expected: Path) -> None:
    check_same_grids(run, expected)
    assert lines_of(run) == lines_of(expected)
    facts = [json.loads((folder / "run.json").read_text()) for folder in (run, expected)]
    assert facts[0]["frames"]["complete"]
    assert all(facts[0][key] == facts[1][key] for key in ("config", "input", "frames"))


def writer(folder: Path, drive: Path, **options: Any) -> sg.RunWriter:
    recording = sg.open(drive)
    return sg.RunWriter(folder, recording, pipeline_of(recording), **options)


def write(folder: Path, drive: Path, **options: Any) -> None:
    write_run(folder, sg.open(drive), **options)


def test_a_folder_has_one_writer(drive: Path, tmp_path: Path) -> None:
    with writer(tmp_path, drive):
        for resume in (False, True):
            with pytest.raises(sg.DeviceError, match=f"another stereogrid is writing to .* .process {os.getpid()}"):
                writer(tmp_path, drive, resume=resume)
    with pytest.raises(sg.ConfigError, match="already holds a run"):
        writer(tmp_path, drive)
    writer(tmp_path, drive, resume=True).close()
    assert not (tmp_path / ".lock").exists()


def test_the_preset_of_the_cameras_height(tmp_path: Path) -> None:
    low, high = (f"scene:{scene}frames=1&width=160&height=100" for scene in ("corridor?camera=robot&", "street?"))
    assert [sg.preset_for(sg.open(scene)) for scene in (low, high)] == ["robot", "default"]
    assert sg.run(low, tmp_path / "auto", config="auto").preset == "robot"
    with pytest.warns(RuntimeWarning, match="--preset robot is made for a camera 0.35 m above the ground"):
        sg.run(low, tmp_path / "default")


def test_frames_are_taken_in_their_order_and_once(drive: Path, tmp_path: Path) -> None:
    with writer(tmp_path, drive) as run:
        frames = list(run)
        run.process(frames[1])
        for refused in (frames[0], frames[1]):
            with pytest.raises(sg.InputError, match=r"index . \(allowed 2 … .\)"):
                run.process(refused)
        run.process(frames[2])
    assert [line["index"] for line in lines_of(tmp_path)] == [1, 2]
    assert len(sg.read_run(tmp_path)) == 2


def test_a_closed_writer_takes_no_frame(drive: Path, tmp_path: Path) -> None:
    run = writer(tmp_path, drive)
    frames = list(run)
    run.process(frames[0])
    run.close()
    before = (tmp_path / "frames.jsonl").read_bytes()
    with pytest.raises(ValueError, match="closed"):
        run.process(frames[1])
    with pytest.raises(ValueError, match="closed"):
        next(iter(run))
    assert (tmp_path / "frames.jsonl").read_bytes() == before
    assert not list((tmp_path / "grids").glob(f"{frames[1].name}*"))


@pytest.mark.tool
def test_the_tool_respects_a_writer(tool: Any, drive: Path, tmp_path: Path) -> None:
    with writer(tmp_path, drive), pytest.raises(AssertionError, match="another stereogrid is writing"):
        tool("run", drive, "--out", tmp_path, "--resume")


@pytest.mark.tool
@pytest.mark.parametrize("checkpoint_every", [0, 2, 100])
@pytest.mark.parametrize("poses", [None, "odometry"])
def test_a_stopped_run_continues(
    poses: str | None, checkpoint_every: int, tool: Any, drive: Path, tmp_path: Path
) -> None:
    tool("run", drive, "--out", tmp_path / "tool", "--device", "cpu", *(["--poses", poses] if poses else []))
    for count in (3, 1, 100):  # stopped twice
        recording = sg.open(drive, poses=poses)
        options: dict[str, Any] = {"resume": True, "checkpoint_every": checkpoint_every}
        with sg.RunWriter(tmp_path / "run", recording, pipeline_of(recording), **options) as run:
            for frame in run:
                run.process(frame)
                if frame.index == count:
                    break
    check_equal(tmp_path / "run", tmp_path / "tool")


@pytest.mark.tool
def test_the_tool_continues_a_run(tool: Any, drive: Path, tmp_path: Path) -> None:
    tool("run", drive, "--out", tmp_path / "tool", "--device", "cpu")
    write(tmp_path / "run", drive, count=3)
    assert not json.loads((tmp_path / "run/run.json").read_text())["frames"]["complete"]
    tool("run", drive, "--out", tmp_path / "run", "--device", "cpu", "--resume")
    check_equal(tmp_path / "run", tmp_path / "tool")


def test_a_killed_run_continues(drive: Path, tmp_path: Path) -> None:
    write(tmp_path / "whole", drive)
    process = get_context("spawn").Process(target=end_killed, args=(tmp_path / "run", drive))
    process.start()
    process.join()
    assert process.exitcode == -signal.SIGKILL and (tmp_path / "run/.lock").exists()
    write(tmp_path / "run", drive, resume=True)
    check_equal(tmp_path / "run", tmp_path / "whole")


def end_killed(folder: Path, drive: Path) -> None:
    run = writer(folder, drive, checkpoint_every=2)
    for frame in run:
        run.process(frame)
        if frame.index == 3:
            os.kill(os.getpid(), signal.SIGKILL)


def test_settings_of_a_stopped_run(drive: Path, tmp_path: Path) -> None:
    write(tmp_path, drive, count=2)
    recording = sg.open(drive)
    with pytest.raises(sg.ConfigError, match="was begun with other settings"):
        sg.RunWriter(tmp_path, recording, sg.Pipeline(sg.preset("robot"), recording.rig), resume=True)
    with writer(tmp_path, drive, resume=True) as run:
        with pytest.raises(ValueError, match="iterate over the RunWriter"):
            run.process(recording[0])
        assert [frame.index for frame in run] == [2, 3, 4, 5]
        with pytest.raises(ValueError, match="iterated once"):
            iter(run)


@pytest.mark.tool
def test_fusion_with_lidar(tool: Any, kitti: Path, drive: Path, tmp_path: Path) -> None:
    tool("run", kitti, "--out", tmp_path / "tool", "--device", "cpu", "--fuse", "lidar")
    write(tmp_path / "run", kitti, fuse="lidar")
    check_equal(tmp_path / "run", tmp_path / "tool")
    write(tmp_path / "alone", kitti)
    assert lines_of(tmp_path / "alone") != lines_of(tmp_path / "run")
    with pytest.raises(sg.InputError, match="--fuse"):
        writer(tmp_path / "none", drive, fuse="lidar")
    with pytest.raises(sg.ConfigError, match=r"fuse 'radar' .allowed: none, lidar"):
        writer(tmp_path / "none", drive, fuse="radar")


def test_run(drive: Path, tmp_path: Path) -> None:
    run = sg.run(drive, tmp_path / "run", frames="1:4")
    assert [frame.index for frame in run.frames] == [1, 2, 3, 4]
    config = sg.preset("default")
    config.grid.length_m = 10
    again = sg.run(sg.open(drive)[:2], tmp_path / "short", config=config, device="cpu")
    assert len(again) == 2 and again.grid.nx == 50
    assert len(sg.run(drive, tmp_path / "run", frames="1:4", resume=True)) == 4
    with pytest.raises(sg.ConfigError, match="already holds a run"):
        sg.run(drive, tmp_path / "run")
    with pytest.raises(TypeError, match="frames"):
        sg.run(sg.open(drive), tmp_path / "other", frames="1:4")


def test_bar_of_a_run(drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    for stream, is_shown in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(sys, "stderr", stream)
        sg.run(drive, tmp_path / str(is_shown), frames="0:1")
        assert ("2/2 frames" in stream.getvalue()) == is_shown
    monkeypatch.setattr(sys, "stderr", Terminal())
    sg.run(drive, tmp_path / "silent", frames="0:1", bar=False)
    assert not sys.stderr.getvalue()  # type: ignore[attr-defined]
