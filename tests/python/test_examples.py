# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""examples/python/, each as a user would call it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ROOT

import stereogrid as sg

EXAMPLES = ROOT / "examples/python"
pytestmark = pytest.mark.skipif(not EXAMPLES.exists(), reason="no examples here")


def call(name: str, *arguments: str | Path) -> str:
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_kitti(kitti: Path) -> None:
    lines = call("kitti.py", kitti).splitlines()
    assert len(lines) == 4 and lines[3].startswith("000003: ")


def test_own_disparities(drive: Path) -> None:
    pytest.importorskip("cv2")
    lines = call("own_disparities.py", drive).splitlines()
    assert len(lines) == 6 and int(lines[-1].split()[1]) > 20


def test_sweep() -> None:
    lines = call("sweep.py", "filter.decay_time_s", "1", "4").splitlines()
    assert [line.split(":")[0] for line in lines] == ["filter.decay_time_s=1", "filter.decay_time_s=4"]
    assert all(float(line.split()[1]) < 30 for line in lines)


def test_score_lidar(kitti: Path, tmp_path: Path) -> None:
    recording = sg.open(kitti)
    config = sg.preset("default")
    with sg.RunWriter(tmp_path / "run", recording, sg.Pipeline(config, recording.rig)) as run:
        for frame in recording:
            run.process(frame)
    text = call("score_lidar.py", tmp_path / "run")
    assert "4 frames of preset default" in text
    assert re.search(r"^occupancy 3-20: .*'missed': 0\.\d", text, re.M)


def kill_a_worker(parent: int) -> bool:
    """Kills a child of a child that is at work; children of a cluster are its workers."""
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text().rsplit(")", 1)[1].split()
                command = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if int(stat[1]) == parent and b"spawn_main" in command:
                os.kill(int(entry.name), signal.SIGKILL)
                return True
    return False


def test_dask_loses_nothing_when_a_worker_is_killed(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    drives = [f"scene:street?frames=12&seed={seed}&width=256&height=160" for seed in range(8)]
    command = [sys.executable, str(EXAMPLES / "dask_drives.py"), str(tmp_path / "out"), *drives]
    errors = tmp_path / "errors.txt"
    with errors.open("w") as log, subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True) as running:
        assert running.stdout is not None
        lines = [running.stdout.readline().strip()]
        killed = kill_a_worker(running.pid)
        # not communicate(): it would lose the lines that readline() has buffered
        lines += running.stdout.read().splitlines()
    assert running.returncode == 0, errors.read_text()
    assert killed
    assert sorted(lines) == sorted(f"{drive}: 12 frames" for drive in drives)
    # without the part that the killed worker may have left
    files = sorted((tmp_path / "out").glob("[!.]*.npz"))
    assert len(files) == len(drives)
    for file in files:
        with np.load(file) as arrays:
            assert arrays["frames"] == 12
    # complete files are not computed again
    before = time.time()
    assert call("dask_drives.py", tmp_path / "out", *drives).count("12 frames") == len(drives)
    assert all(file.stat().st_mtime < before for file in files)
