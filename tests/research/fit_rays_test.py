#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""fit_rays.py counts as the library does, and finds weights that separate occupied and free cells.

fit_rays_test.py TOOL
"""
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

try:
    import numpy as np
except ImportError:
    print("skipped: needs numpy (Debian: python3-numpy)")
    sys.exit(77)

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "research"))
import fit_rays  # noqa: E402

HEADER = ROOT / "src/observation/rays/weights.hpp"
SCENES = {name: f"{name}?frames=3&width=400&height=240&focal=330" for name in ("street", "crossing")}


def weights_of(header: Path) -> np.ndarray:
    values = re.search(r"float value\[cell_rays\]\{([^}]*)\}", header.read_text())[1]
    return np.array([float(value.rstrip("f")) for value in values.split(", ")])


class FitRays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.pairs = []
        for name, scene in SCENES.items():
            data, run = cls.folder / name, cls.folder / f"{name}-run"
            subprocess.run([TOOL, "simulate", scene, "--out", data, "--quiet"], check=True)
            subprocess.run([TOOL, "run", data, "--out", run, "--save-stages", "--quiet",
                            "--set", "ground.model=plane"], check=True)
            cls.pairs.append((run, data))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def test_probabilities_are_those_of_the_library(self):
        weights = weights_of(HEADER)
        for run, data in self.pairs:
            inputs, _, _, expected = fit_rays.samples_of(run, data, 20, with_observed=True)
            log_odds, _ = fit_rays.limited(inputs @ weights)
            p = np.clip(1 / (1 + np.exp(-log_odds)), 0.001, 0.999)
            self.assertGreater(len(p), 1000)
            self.assertLess(np.abs(p - expected).max(), 0.002)

    def test_weights_are_fitted_and_written(self):
        header = self.folder / "weights.hpp"
        shutil.copy(HEADER, header)
        pairs = [f"{run}={data}" for run, data in self.pairs]
        command = [sys.executable, ROOT / "research/fit_rays.py", *pairs, "--header", header]
        printed = subprocess.run(command, check=True, text=True, capture_output=True).stdout
        losses = [float(line.split("|")[2]) for line in printed.splitlines() if re.match(r"\| (street|crossing)", line)]
        self.assertEqual(len(losses), 2)
        self.assertLess(max(losses), 0.5)
        fitted = weights_of(header)
        self.assertEqual(len(fitted), len(fit_rays.NAMES))
        self.assertGreater(fitted[0], 0.1, "what ends in a cell makes it occupied")
        self.assertIn("Fitted on street, crossing", header.read_text())


if __name__ == "__main__":
    TOOL = sys.argv.pop(1)
    unittest.main()
