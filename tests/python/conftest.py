# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Drives and results that the tests share."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import stereogrid as sg

ROOT = Path(__file__).parents[2]
SCENE = "scene:street?frames=4&width=256&height=160"


@pytest.fixture(scope="session")
def scene() -> sg.Recording:
    return sg.simulate(SCENE)


@pytest.fixture(scope="session")
def frames(scene: sg.Recording) -> list[sg.Frame]:
    return list(scene)


@pytest.fixture
def pipeline(scene: sg.Recording) -> sg.Pipeline:
    return sg.Pipeline(sg.preset("default"), scene.rig, device="cpu")


@pytest.fixture(scope="session")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plain folder with truth."""
    folder = tmp_path_factory.mktemp("drives") / "drive"
    sg.simulate("street", frames=6, width_px=256, height_px=160).save(folder)
    return folder


@pytest.fixture(scope="session")
def tool() -> Callable[..., str]:
    """Runs the command-line tool."""
    program = os.environ.get("STEREOGRID_TOOL", "")
    if not program:
        pytest.skip("the tool is not built (STEREOGRID_TOOL is not set)")

    def call(*arguments: Any) -> str:
        command = [program, "--quiet", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call
