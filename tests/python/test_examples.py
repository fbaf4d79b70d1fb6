# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""examples/python/, each as a user would call it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

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
