#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""research/compare.py: compare_test.py PROGRAMS [unittest's arguments], where PROGRAMS is the folder of stereogrid and
stereogrid-baselines."""
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "research"))
try:
    import numpy as np
    import stereogrid  # noqa: F401

    import compare
except ImportError as error:
    print(f"skipped: {error.name} is not installed")
    sys.exit(77)

PROGRAMS = Path(sys.argv.pop(1)).resolve()
SCENE = "scene:street?frames=3&width=256&height=160"
DATA = Path(os.environ.get("STEREOGRID_DATA", Path(__file__).resolve().parents[3] / "shared/data"))


class Compare(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def compared(self, *words):
        return subprocess.run([sys.executable, compare.__file__, PROGRAMS, *words], capture_output=True, text=True, check=False)

    def test_every_method_separates_obstacles_from_free_space(self):
        names = [name for name in compare.METHODS if name not in compare.NEED_LIDAR]
        compare.made(PROGRAMS, SCENE, self.work, [], names)
        for name in names:
            _, run, series = compare.METHODS[name]
            scored = compare.scores(PROGRAMS, self.work / run, [])[series]["bands"]["3-20"]
            self.assertEqual(scored["frames"], 3, name)
            self.assertGreater(scored["auc"]["value"], 0.8, name)
        with np.load(self.work / "own/grids/000002.npz") as own, np.load(self.work / "stixels/grids/000002.npz") as other:
            self.assertEqual(own["observed"].shape, other["observed"].shape)
            self.assertFalse(np.array_equal(own["observed"], other["observed"]))

    def test_a_table_and_a_figure(self):
        done = self.compared(SCENE, "--frames=1:2", "--only", "observed,stixels", "--figure", self.work / "grids.png")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("(2 frames", done.stdout)
        self.assertEqual([line.split("`")[1] for line in done.stdout.splitlines() if "`" in line], ["observed", "stixels"])
        self.assertGreater((self.work / "grids.png").stat().st_size, 10_000)

    def test_unknown_methods_are_named(self):
        done = self.compared(SCENE, "--only", "stixel")
        self.assertEqual(done.returncode, 1)
        self.assertIn("stixel (allowed: observed", done.stderr)

    def test_rings_are_held_out(self):
        drive = self.work / "drive"
        (drive / "velodyne").mkdir(parents=True)
        ring = [(1, y, 0, 0) for y in (-1, 1)]  # across the direction ahead
        np.array(3 * [*ring, (-1, 0, 0, 0)], np.float32).tofile(drive / "velodyne" / "0.bin")
        sizes = [len(np.fromfile(compare.thinned(drive, self.work / str(even), even) / "velodyne/0.bin", np.float32)) // 4
                 for even in (True, False)]
        self.assertEqual(sizes, [4, 5])

    def test_lidar_of_a_drive(self):
        if not (DATA / "kitti_odo04").exists():
            self.skipTest("no data sets on this machine (STEREOGRID_DATA)")
        done = self.compared(DATA / "kitti_odo04", "--frames=0:0", "--only", "lidar,fused", "--hold-out")
        self.assertEqual(done.returncode, 0, done.stderr)
        losses = [float(line.split("|")[3]) for line in done.stdout.splitlines() if "| all |" in line]
        self.assertEqual(len(losses), 2)
        self.assertLess(max(losses), 0.3)


if __name__ == "__main__":
    unittest.main()
