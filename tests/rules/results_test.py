#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""scripts/results.py makes a page of bench/results.json, which scripts/measure.py writes."""
import sys
import tempfile
import unittest
from decimal import Decimal
from pathlib import Path
from unittest import mock

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import measure  # noqa: E402
import results  # noqa: E402

PRINTED = """Some words.

## street, 3 frames

**Road**, 12 points

| what | ms | ratio |
|---|---|---|
| a | 1.50 | 0.2 / 0.3 |
| *over time* |||
| b | – | -3 |

| other |
| :-- |
| 077 |
"""


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


class Measuring(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        patch = mock.patch.object(results, "FILE", self.folder / "results.json")
        patch.start()
        self.addCleanup(patch.stop)
        results.save({})
        patch = mock.patch.object(measure, "commit", return_value="0123abc")
        self.clean = patch.start()
        self.addCleanup(patch.stop)

    def measure(self, *arguments):
        with mock.patch.object(sys, "argv", ["measure.py", *arguments]), mock.patch("builtins.print"):
            return measure.main()

    def test_tables_are_read(self):
        first, second = measure.tables_of(PRINTED)
        self.assertEqual(first["title"], "street, 3 frames: Road, 12 points")
        self.assertEqual(first["columns"], ["what", "ms", "ratio"])
        self.assertEqual(first["rows"], [["a", Decimal("1.50"), "0.2 / 0.3"], ["*over time*", "", ""], ["b", None, Decimal(-3)]])
        self.assertEqual(second, {"title": "street, 3 frames", "columns": ["other"], "rows": [["077"]]})

    def test_a_measurement_is_kept_with_its_origin(self):
        program = self.folder / "bench"
        program.write_text(f"#!/bin/sh\ncat <<'END'\n{PRINTED}END\n", encoding="utf-8")
        program.chmod(0o755)
        texts = ["--section", "Time", "--title", "Streets", "--about", "What it is."]
        self.assertEqual(self.measure("new", "--", str(program)), 64, "a new one needs its texts")
        self.assertEqual(self.measure("new", *texts, "--", str(program), "--fast"), 0)
        self.assertIn("1.50", results.FILE.read_text(encoding="utf-8"), "digits stay")
        kept = results.load()["new"]
        self.assertEqual((kept["title"], kept["command"], len(kept["tables"])), ("Streets", "bench --fast", 2))
        self.assertEqual(kept["commit"], "0123abc")
        self.assertRegex(kept["machine"], r"^\d+ cores, .+, family .+, model .+, stepping .+, SIMD \w+$")
        self.assertIn("| a | 1.50 | 0.2 / 0.3 |", results.page())
        self.assertEqual(self.measure("new", "--", "false"), 1)
        self.clean.return_value = ""
        self.assertEqual(self.measure("new", "--", str(program)), 64, "figures of a tree that nobody else has")
        self.assertEqual(results.load(), {"new": kept}, "what fails changes nothing")

    def test_a_tree_with_changes_has_no_commit(self):
        mock.patch.stopall()
        for status, expected in (("", "0123abc"), (" M src/camera.cpp\n", "")):
            with mock.patch.object(measure, "git", side_effect=["0123abc\n", status]):
                self.assertEqual(measure.commit(), expected)

    def test_a_machine_is_more_than_a_name(self):
        zen4 = ("model name\t: AMD EPYC\ncpu family\t: 25\nmodel\t\t: 17\nstepping\t: 1\n"
                "flags\t\t: fpu avx2 fma bmi2 avx512f avx512bw avx512dq avx512vl avx512_vbmi2 avx512_vnni vaes\n")
        self.assertEqual(measure.machine(zen4, 2), "2 cores, AMD EPYC, family 25, model 17, stepping 1, SIMD AVX3_DL")
        self.assertIn("SIMD AVX2", measure.machine(zen4.replace("avx512", "x"), 2))
        self.assertIn("unknown", measure.machine("", 2))

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
        results.save({"one": good})
        results.load()
        for wrong in ({"commit": ""}, {"date": "today"}, {"section": "None"}, {"machine": None},
                      {"tables": [{"title": "", "columns": ["a", "b"], "rows": [[1]]}]}):
            results.save({"one": good | wrong})
            with self.assertRaises(ValueError, msg=str(wrong)):
                results.load()


if __name__ == "__main__":
    unittest.main()
