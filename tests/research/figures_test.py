#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The paper's figures show what the runs hold: figures_test.py PROGRAMS [unittest's arguments], where PROGRAMS is the
folder of stereogrid and stereogrid-compare."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import figures_support  # noqa: F401 (first)
import numpy as np

import equations
import figures
import make_figures
import panels
import run_folder

PROGRAMS = Path(sys.argv.pop(1)).resolve()


def small(scene, more):
    return f"scene:{scene}?width=160&height=100{more}"


def stereogrid(*words):
    subprocess.run([PROGRAMS / "stereogrid", "--quiet", *words], check=True, stdout=subprocess.DEVNULL)


def made(*words):
    """Runs make_figures.py: its exit code, and what it and the programs have said."""
    outcome = subprocess.run([sys.executable, make_figures.__file__, "--programs", PROGRAMS, *words],
                             capture_output=True, text=True, check=False)
    return outcome.returncode, outcome.stdout + outcome.stderr


class OfARun(unittest.TestCase):
    """Five frames of a street, with everything that the figures need."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.work = Path(cls.folder.name)
        cls.runs = make_figures.make_runs(small("street", "&frames=5"), cls.work, PROGRAMS,
                                          ["--preset", "paper", "--frames", "0:2"])
        cls.drawn_run = run_folder.Run(cls.work / "run")

    def shown(self, figure, title):
        """Image of the panel with this title."""
        parts = [figure, *figure.subfigs]
        axes = [axes for part in parts for axes in part.axes if axes.get_title(loc="left").startswith(title)]
        self.assertTrue(axes, title)
        return np.asarray(axes[-1].images[0].get_array())

    def test_every_figure_but_the_lidars_is_drawn(self):
        drawn, left_out = figures.draw(**self.runs)
        figures.save(drawn, self.work / "out")
        names = sorted(path.name for path in (self.work / "out").iterdir())
        self.assertEqual(names, [f"figure_{number}.png" for number in (1, 2, 3, 4, 6, 7, 8)])
        self.assertEqual(left_out, ["Figure 9 is left out: frame 000002 has no lidar sweep."])
        for name in names:
            image = figures.matplotlib.image.imread(self.work / "out" / name)
            self.assertGreater(image.shape[0], 300, name)
            self.assertGreater(image.shape[1], 400, name)
            self.assertGreater(len(np.unique(image)), 20, name)

    def test_they_show_the_runs_files(self):
        drawn, _ = figures.draw(**self.runs)
        stages, grids = self.drawn_run.arrays("stages", "000002"), self.drawn_run.arrays("grids", "000002")
        compared = np.load(self.work / "compared" / "000002.npz")
        without = np.load(self.work / "without_gaussian" / "grids" / "000002.npz")
        raised = np.load(self.work / "false_positive" / "grids" / "000002.npz")
        unnoticed = np.load(self.work / "false_negative" / "grids" / "000002.npz")
        for number, title, expected in (
                (3, "(b)", stages["observed_pixels"]), (3, "(d)", stages["visibility"]),
                (3, "(e)", stages["obstacle_confidence"]), (3, "(f)", stages["road_confidence"]),
                (3, "(g) occupancy", stages["u_occupancy_smooth"]), (3, "(g) the same", grids["observed"].T),
                (4, "(a)", stages["u_occupancy"]), (4, "(c)", without["observed"].T), (4, "(e)", grids["occupancy"].T),
                (6, "(c)", compared["nearest_obstacle_paper"].T), (6, "(d)", grids["observed"].T),
                (6, "(e)", compared["nearest_obstacle"].T),
                (7, "u-disparity grid", stages["u_occupancy"]), (7, "filtered", grids["occupancy"].T),
                (8, "frame alone, P_FP = 0.02, P_FN = 0.02", grids["observed"].T),
                (8, "frame alone, P_FP = 0.25, P_FN = 0.02", raised["observed"].T),
                (8, "filtered, P_FP = 0.25, P_FN = 0.02", raised["occupancy"].T),
                (8, "frame alone, P_FP = 0.02, P_FN = 0.25", unnoticed["observed"].T)):
            np.testing.assert_array_equal(self.shown(drawn[number], title), expected, f"{number} {title}")
        left = figures.matplotlib.image.imread(next((self.work).glob("scene*/left/000002.png")))
        np.testing.assert_array_equal(self.shown(drawn[3], "(a)"), left)
        truth = self.shown(drawn[6], "what is there")
        self.assertTrue({panels.SEEN_OCCUPIED, panels.SEEN_FREE, panels.HIDDEN} <= set(truth.ravel()))
        self.assertFalse(np.array_equal(without["observed"], grids["observed"]))
        for rated in (raised, unnoticed):
            self.assertFalse(np.array_equal(rated["observed"], grids["observed"]))
        matched = self.shown(drawn[6], "(b)")
        np.testing.assert_array_equal(matched, np.maximum(stages["obstacle_disparity"], stages["road_disparity"]))

    def test_the_formulas_are_the_pipelines(self):
        stages, config = self.drawn_run.arrays("stages", "000002"), figures.bin_parameters(self.drawn_run)
        rows, columns = stages["u_occupancy"].shape
        observed = np.divide(stages["observed_pixels"], stages["visible"], where=stages["visible"] > 0,
                             out=np.zeros((rows, columns)))
        has_road = np.pad(equations.road_counts(stages["road_disparity"], rows, self.drawn_run.disparities) > 0, 1)
        around = sum(has_road[i:i + rows, j:j + columns] for i in range(3) for j in range(3)) / 9
        confidence = equations.obstacle_confidence(observed, config["tau_obstacle"])
        road = equations.road_confidence(observed, around, config)
        obstacle = equations.obstacle_probability(stages["visibility"], confidence, config)
        for name, expected in (("obstacle_confidence", confidence), ("road_confidence", road),
                               ("u_occupancy", equations.occupancy(obstacle, road, config))):
            np.testing.assert_allclose(stages[name][1:], expected[1:], atol=1e-5, err_msg=name)
        self.assertGreater((confidence[1:] > 0.5).sum(), 20)
        self.assertGreater((road[1:] > 0.5).sum(), 100)

    def test_an_earlier_frame_may_be_shown(self):
        drawn, left_out = figures.draw(self.work / "run", frame="000001")
        self.assertEqual(sorted(drawn), [1, 2, 3, 7])
        self.assertEqual(len(left_out), 4)
        np.testing.assert_array_equal(self.shown(drawn[3], "(d)"), self.drawn_run.arrays("stages", "000001")["visibility"])

    def test_an_unknown_frame_is_complained_of(self):
        out = self.work / "never"
        outcome = subprocess.run([sys.executable, figures.__file__, self.work / "run", "--out", out, "--frame", "7"],
                                 capture_output=True, text=True, check=False)
        self.assertNotEqual(outcome.returncode, 0)
        self.assertIn("has no frame 7. It has 3, 000000 to 000002.", outcome.stderr)
        self.assertFalse(out.exists())

    def test_where_nothing_can_be_written_is_complained_of(self):
        (self.work / "file").write_text("not a folder")
        with self.assertRaisesRegex(run_folder.Complaint, "file/out: cannot be written"):
            figures.save({}, self.work / "file" / "out")


class OfADrive(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def test_a_lidar_sweep_is_shown(self):
        """As KITTI's odometry has it: a sweep for one frame, of a wall 5 m ahead on a road."""
        drive = self.work / "drive"
        stereogrid("simulate", small("street", "&frames=4"), "--out", drive, "--no-truth")
        (drive / "left").rename(drive / "image_0")
        (drive / "right").rename(drive / "image_1")
        (drive / "calibration.yaml").unlink()
        (drive / "poses.csv").unlink()
        (drive / "calib.txt").write_text("P0: 128.125 0 80 0 0 128.125 50 0 0 0 1 0\n"
                                         "P1: 128.125 0 80 -28.1875 0 128.125 50 0 0 0 1 0\n"
                                         "Tr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n")
        (drive / "velodyne").mkdir()
        road = [(x, y, -1.64) for x in np.arange(4, 12, 0.1) for y in np.arange(-3, 3, 0.1)]
        wall = [(5, y, -0.7) for y in np.arange(-1, 1, 0.02)]
        np.array([(*point, 0) for point in road + wall], np.float32).tofile(drive / "velodyne" / "000003.bin")
        runs = make_figures.make_runs(str(drive), self.work / "runs", PROGRAMS, ["--preset", "paper"])
        drawn, left_out = figures.draw(**runs)
        self.assertEqual(left_out, [])
        scanned = next(axes for axes in drawn[9].axes if axes.get_title(loc="left").startswith("(c)"))
        upright = scanned.collections[2].get_offsets()
        self.assertEqual(len(upright), len(wall))
        np.testing.assert_allclose(upright[:, 1], 5, atol=1e-5)
        self.assertTrue(any(axes.get_title(loc="left") == "lidar, from above" for axes in drawn[6].axes))
        self.assertEqual(figures.draw(**{**runs, "frame": "000001"})[1],
                         ["Figure 9 is left out: frame 000001 has no lidar sweep."])

    def test_a_damaged_frame_before_is_skipped_and_the_frame_itself_is_not(self):
        drive = self.work / "drive"
        stereogrid("simulate", small("street", "&frames=3"), "--out", drive, "--no-truth")
        damaged = drive / "left" / "000000.png"
        damaged.write_bytes(damaged.read_bytes()[:100])
        stereogrid("run", drive, "--out", self.work / "run", "--save-stages", "--frames", "0:1")
        self.assertEqual(sorted(figures.draw(self.work / "run")[0]), [1, 2, 3, 7])
        code, said = made(str(drive), "--frames", "0:0", "--out", str(self.work / "out"))
        self.assertEqual(code, 65)
        self.assertIn("000000.png", said)

    def test_settings_are_followed(self):
        drive = self.work / "drive"
        stereogrid("simulate", small("street", "&frames=1"), "--out", drive)
        for name, words in (("as_set", ()), ("other", ("--set", "paper.false_positive=0.2"))):
            stereogrid("run", drive, "--out", self.work / name, "--save-stages", "--preset", "paper", *words)
        first, third = ([figures.draw(self.work / name)[0][number].axes for name in ("as_set", "other")]
                        for number in (1, 3))
        self.assertFalse(np.array_equal(*(axes[1].images[0].get_array() for axes in first)))
        self.assertFalse(np.array_equal(*(axes[7].images[0].get_array() for axes in third)))

    def test_no_input_is_a_street(self):
        code, said = made("--frames", "0:0", "--out", str(self.work / "out"))
        self.assertEqual(code, 0, said)
        self.assertTrue((self.work / "out" / "figure_8.png").is_file())

    def test_what_is_missing_is_said(self):
        code, said = made(str(self.work / "nothing"), "--out", str(self.work / "out"))
        self.assertEqual(code, 65)
        self.assertIn("nothing", said)
        code, said = made()
        self.assertEqual(code, 2)
        self.assertIn("--out", said)
        with self.assertRaisesRegex(run_folder.Complaint, "has no run.json"):
            figures.draw(self.work)
        drive = self.work / "drive"
        stereogrid("simulate", small("street", "&frames=1"), "--out", drive)
        stereogrid("run", drive, "--out", self.work / "run")
        with self.assertRaisesRegex(run_folder.Complaint, "Run again with --save-stages"):
            figures.draw(self.work / "run")
        stereogrid("run", small("street", "&frames=1"), "--out", self.work / "scene", "--save-stages")
        with self.assertRaisesRegex(run_folder.Complaint, "stereogrid simulate"):
            figures.draw(self.work / "scene")


if __name__ == "__main__":
    unittest.main()
