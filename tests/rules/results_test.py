#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""scripts/results.py makes a page of bench/results.json, and rejects incomplete measurements."""
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import results  # noqa: E402


class Page(unittest.TestCase):
    def test_every_measurement_is_on_it(self):
        page = results.page()
        measurements = results.load()
        self.assertTrue(measurements)
        for measurement in measurements.values():
            self.assertIn(f"### {measurement['title']}\n", page)

    def test_the_file_is_as_it_is_written(self):
        kept, measurements = results.FILE.read_text(encoding="utf-8"), results.load()
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(results, "FILE", Path(folder) / "again.json"):
            results.save(measurements)
            self.assertEqual(results.FILE.read_text(encoding="utf-8"), kept)

    def test_rows_that_constants_were_fitted_on_are_marked(self):
        table = {"title": "", "columns": ["input", "x"], "rows": [["kitti_odo04, observed", 1], ["kitti_raw0001", 2],
                                                                  ["C street", 3]]}
        text = results.table_text(table, "Grids against lidar")
        self.assertIn("| kitti_odo04, observed † | 1 |", text)
        self.assertIn("| kitti_raw0001 | 2 |", text)
        self.assertIn("| C street † | 3 |", text)
        self.assertNotIn("†", results.table_text(table, "Time"))

    def test_older_captions_say_what_they_lack(self):
        old = {"command": "x", "date": "2026-11-21", "commit": "0123abc+", "machine": "2 cores, AMD EPYC"}
        self.assertIn("0123abc with changes that were not committed", results.source_text(old))
        self.assertIn("not recorded", results.source_text(old))
        new = old | {"commit": "0123abc", "machine": "2 cores, AMD EPYC, family 25, model 17, stepping 1, SIMD AVX2"}
        self.assertEqual(results.source_text(new), f"`x`, 2026-11-21, commit 0123abc, {new['machine']}.")

    def test_what_is_incomplete_is_refused(self):
        good = {"section": "Time", "title": "t", "about": "a", "date": "2026-11-21", "commit": "c", "machine": "m",
                "command": "x", "tables": [{"title": "", "columns": ["a", "b"], "rows": [[1, 2]]}]}
        results.check("one", good)
        for wrong in ({"commit": ""}, {"date": "today"}, {"section": "None"}, {"machine": None},
                      {"tables": [{"title": "", "columns": ["a", "b"], "rows": [[1]]}]}):
            with self.assertRaises(ValueError, msg=str(wrong)):
                results.check("one", good | wrong)


if __name__ == "__main__":
    unittest.main()
