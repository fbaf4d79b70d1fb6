# SPDX-License-Identifier: Apache-2.0
"""Type stubs and style."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

import stereogrid

PACKAGE = Path(stereogrid.__file__).parent


def check(*command: str | Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", *map(str, command)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs_name_every_public_class_and_function() -> None:
    assert (PACKAGE / "py.typed").exists()
    stub = (PACKAGE / "_core.pyi").read_text()
    for name in stereogrid.__all__:
        assert (
            name in ("evaluate", "run") or f"class {name}" in stub or f"def {name}(" in stub or f"\n{name}" in stub
        ), name
    assert "object" not in stub.split("class Pipeline")[1].split("class ")[0]


def test_mypy() -> None:
    pytest.importorskip("mypy")
    if not (ROOT / "pyproject.toml").exists():
        pytest.skip("no sources here")
    check("mypy", "--strict", "-p", "stereogrid")


def test_mypy_of_tests_and_examples() -> None:
    pytest.importorskip("mypy")
    if not (ROOT / "examples/python").exists():
        pytest.skip("no sources here")
    for file in sorted((ROOT / "examples/python").glob("*.py")):
        check("mypy", file)


def test_ruff() -> None:
    pytest.importorskip("ruff")
    if not (ROOT / "pyproject.toml").exists():
        pytest.skip("no sources here")
    check("ruff", "check", ".")
    check("ruff", "format", "--check", ".")
