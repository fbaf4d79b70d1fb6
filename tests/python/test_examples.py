# SPDX-License-Identifier: Apache-2.0
"""The programs and notebooks of examples/python/ and the snippets of docs/python.md, as a user would call them; types
and style."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

import stereogrid as sg

EXAMPLES = ROOT / "examples/python"
PAGE = ROOT / "docs/python.md"
pytestmark = pytest.mark.skipif(not EXAMPLES.exists(), reason="no sources here")


def call(name: str, *arguments: str | Path) -> str:
    command = [sys.executable, str(EXAMPLES / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_kitti(kitti: Path) -> None:
    lines = [line for line in call("kitti.py", kitti).splitlines() if "occupied cells" in line]
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


@pytest.mark.parametrize("name", sorted(file.name for file in EXAMPLES.glob("*.ipynb")))
def test_notebooks(name: str, tmp_path: Path) -> None:
    for package in ("ipykernel", "matplotlib", "pandas"):
        pytest.importorskip(package)
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(EXAMPLES / name, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code), "stored without outputs"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = [kind for cell in code for output in cell.outputs for kind in output.get("data", {})]
    assert kinds.count("image/png") >= 3
    errors = [output.text for cell in code for output in cell.outputs if output.get("name") == "stderr"]
    assert not errors


def test_snippets(drive: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if not PAGE.exists():
        pytest.skip("no docs here")
    shutil.copytree(drive, tmp_path / "drive")
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    snippets = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(snippets) >= 6
    for snippet in snippets:
        if "plot" in snippet:
            pytest.importorskip("matplotlib").use("Agg")
        exec(compile(snippet, str(PAGE), "exec"), names)
    assert (tmp_path / "frame.png").stat().st_size > 10_000
    assert (tmp_path / "run/run.json").exists() and (tmp_path / "street/truth").is_dir()


def check(*command: str | Path) -> None:
    line = [sys.executable, "-m", *map(str, command)]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy() -> None:
    pytest.importorskip("mypy")
    check("mypy", "--strict", "-p", "stereogrid")


def test_mypy_of_tests_and_examples() -> None:
    pytest.importorskip("mypy")
    check("mypy", *sorted(EXAMPLES.glob("*.py")))


def test_ruff() -> None:
    pytest.importorskip("ruff")
    check("ruff", "check", ".")
    check("ruff", "format", "--check", ".")
