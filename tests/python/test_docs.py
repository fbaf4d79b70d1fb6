# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The snippets of docs/python.md work, one after the other."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT

PAGE = ROOT / "docs/python.md"


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
