#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""scripts/same_results.py on runs that are equal, and on runs that differ by a parameter.

same_results_test.py TOOL
"""
import shlex
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import numpy  # noqa: F401
except ImportError:
    print("skipped: needs numpy (Debian: python3-numpy)")
    sys.exit(77)

SCRIPT = Path(__file__).resolve().parents[2] / "scripts" / "same_results.py"
SCENE = "scene:crossing?frames=2&width=256&height=160"


class SameResults(unittest.TestCase):
    def compared(self, other: str, *inputs: str) -> "tuple[int, list]":
        """Exit status and lines of a comparison between the tool and the tool with further options."""
        with tempfile.TemporaryDirectory() as folder:
            tool = Path(folder) / "other"
            tool.write_text(f'#!/bin/sh\nexec {shlex.quote(TOOL)} "$@" {other}\n', encoding="utf-8")
            tool.chmod(0o755)
            done = subprocess.run([sys.executable, SCRIPT, TOOL, tool, *inputs], capture_output=True, text=True,
                                  check=False)
        return done.returncode, done.stdout.splitlines()

    def test_equal_runs(self):
        status, lines = self.compared("", SCENE, f"{SCENE} --frames 1:1")
        self.assertEqual(status, 0)
        self.assertEqual([line.split(": ")[-1] for line in lines], ["equal"] * 6)

    def test_a_difference_of_stages_alone(self):
        # the default preset reads sigma_column for its stages only
        status, (default, _, paper) = self.compared("--set paper.sigma_column=1", SCENE)
        self.assertEqual(status, 1)
        self.assertRegex(default, r"stages/000000\.npz: u_occupancy_smooth: [0-9]+ of [0-9]+ values, the first ")
        self.assertNotIn("equal", paper)

    def test_a_difference_of_frames(self):
        status, lines = self.compared("--set tracking.confirm_frames=1", SCENE)
        self.assertEqual(status, 1)
        self.assertRegex(lines[0], r"frames\.jsonl: /0/obstacles/\d+/confirmed: False → True")

    def test_fewer_frames(self):
        status, lines = self.compared("--every 2", SCENE)
        self.assertEqual(status, 1)
        self.assertIn("frames.jsonl: /1: {", lines[0])
        self.assertTrue(lines[0].endswith("→ missing"), lines[0])

    def test_a_tool_that_fails(self):
        status, lines = self.compared("--set no.such=1", SCENE)
        self.assertEqual(status, 1)
        self.assertNotIn("equal", "".join(lines))


if __name__ == "__main__":
    TOOL = sys.argv.pop(1)
    unittest.main()
