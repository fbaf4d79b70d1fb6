#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's figures show what the runs hold, and their geometry: figures_test.py PROGRAMS [unittest's arguments], where
PROGRAMS is the folder of stereogrid and stereogrid-baselines. Exit status 77: Matplotlib or the package is missing."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "research" / "figures"))
try:
    import matplotlib  # noqa: F401
    import numpy as np
    import stereogrid  # noqa: F401

    import figures
    import panels
    import run_folder
except ImportError as error:
    print(f"skipped: {error.name} is not installed")
    sys.exit(77)

PROGRAMS = Path(sys.argv.pop(1)).resolve()
LIDAR_CALIBRATION = ("P0: 128.125 0 80 0 0 128.125 50 0 0 0 1 0\n"
                     "P1: 128.125 0 80 -28.1875 0 128.125 50 0 0 0 1 0\nTr: 0 -1 0 0 0 0 -1 0 1 0 0 0\n")
RIG = SimpleNamespace(width_px=512, height_px=320, focal_px=410, cx_px=256, cy_px=160, baseline_m=0.22)


def small(scene, more):
    return f"scene:{scene}?width=160&height=100{more}"


def panel(figure, title):
    """The axes with this title."""
    return [axes for part in (figure, *figure.subfigs) for axes in part.axes
            if axes.get_title(loc="left").startswith(title)][-1]


class Figures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.work = Path(folder.name)

    def made(self, *words):
        """Runs figures.py: its exit code, and the messages of it and the programs."""
        outcome = subprocess.run([sys.executable, figures.__file__, "--programs", PROGRAMS, *words],
                                 capture_output=True, text=True, check=False)
        return outcome.returncode, outcome.stdout + outcome.stderr

    def test_they_show_the_runs_files(self):
        """Five frames of a street, with everything that the figures but the last need."""
        figures.make_runs(small("street", "&frames=5"), self.work, PROGRAMS, ["--preset", "paper", "--frames", "0:2"])
        drawn = figures.draw(self.work)
        self.assertEqual(sorted(drawn), [1, 2, 3, 4, 6, 7, 8])
        run = run_folder.Run(self.work / "run")
        stages, grids = run.stages(), run.grids()
        nearest, nearest_paper = (np.load(self.work / "compared" / name / "grids/000002.npz")["observed"]
                                  for name in ("nearest_obstacle", "nearest_obstacle_paper"))
        without, raised, unnoticed = (run_folder.Run(self.work / name).grids() for name in figures.VARIANTS)
        for number, title, expected in (
                (3, "(b)", stages["observed_pixels"]), (3, "(d)", stages["visibility"]),
                (3, "(e)", stages["obstacle_confidence"]), (3, "(f)", stages["road_confidence"]),
                (3, "(g) occupancy", stages["u_occupancy_smooth"]), (3, "(g) the same", grids["observed"].T),
                (4, "(a)", stages["u_occupancy"]), (4, "(c)", without["observed"].T), (4, "(e)", grids["occupancy"].T),
                (6, "(b)", np.maximum(stages["obstacle_disparity"], stages["road_disparity"])),
                (6, "(c)", nearest_paper.T), (6, "(d)", grids["observed"].T),
                (6, "(e)", nearest.T),
                (7, "u-disparity grid", stages["u_occupancy"]), (7, "filtered", grids["occupancy"].T),
                (8, "frame alone, P_FP = 0.02, P_FN = 0.02", grids["observed"].T),
                (8, "frame alone, P_FP = 0.25, P_FN = 0.02", raised["observed"].T),
                (8, "filtered, P_FP = 0.25, P_FN = 0.02", raised["occupancy"].T),
                (8, "frame alone, P_FP = 0.02, P_FN = 0.25", unnoticed["observed"].T)):
            np.testing.assert_array_equal(panel(drawn[number], title).images[0].get_array(), expected, f"{number} {title}")
        np.testing.assert_array_equal(panel(drawn[3], "(a)").images[0].get_array(), run.recording[2].left / 255)
        truth = panel(drawn[6], "what is there").images[0].get_array()
        self.assertTrue({panels.SEEN_OCCUPIED, panels.SEEN_FREE, panels.HIDDEN} <= set(truth.ravel()))
        for varied in (without, raised, unnoticed):
            self.assertFalse(np.array_equal(varied["observed"], grids["observed"]))
        self.check_formulas(run)

    def check_formulas(self, run):
        """The drawn formulas are those of the pipeline."""
        stages, config = run.stages(), run.bins
        rows, columns = stages["u_occupancy"].shape
        observed = np.divide(stages["observed_pixels"], stages["visible"], where=stages["visible"] > 0,
                             out=np.zeros((rows, columns)))
        has_road = np.pad(panels.road_counts(stages["road_disparity"], rows, run.disparities) > 0, 1)
        around = sum(has_road[i:i + rows, j:j + columns] for i in range(3) for j in range(3)) / 9
        confidence = panels.obstacle_confidence(observed, config["tau_obstacle"])
        road = panels.road_confidence(observed, around, config)
        obstacle = panels.obstacle_probability(stages["visibility"], confidence, config)
        for name, expected in (("obstacle_confidence", confidence), ("road_confidence", road),
                               ("u_occupancy", panels.occupancy(obstacle, road, config))):
            np.testing.assert_allclose(stages[name][1:], expected[1:], atol=1e-5, err_msg=name)
        self.assertGreater((confidence[1:] > 0.5).sum(), 20)
        self.assertGreater((road[1:] > 0.5).sum(), 100)

    def test_a_lidar_sweep_is_shown(self):
        """As KITTI's odometry has it: a sweep for one frame, of a wall 5 m ahead on a road."""
        drive = self.work / "drive"
        subprocess.run([PROGRAMS / "stereogrid", "-q", "simulate", small("street", "&frames=4"), "--out", drive,
                        "--no-truth"], check=True)
        for name, other in (("left", "image_0"), ("right", "image_1")):
            (drive / name).rename(drive / other)
        (drive / "calibration.yaml").unlink()
        (drive / "poses.csv").unlink()
        (drive / "calib.txt").write_text(LIDAR_CALIBRATION)
        (drive / "velodyne").mkdir()
        road = [(x, y, -1.64) for x in np.arange(4, 12, 0.1) for y in np.arange(-3, 3, 0.1)]
        wall = [(5, y, -0.7) for y in np.arange(-1, 1, 0.02)]
        np.array([(*point, 0) for point in road + wall], np.float32).tofile(drive / "velodyne" / "000003.bin")
        figures.make_runs(str(drive), self.work, PROGRAMS, ["--preset", "paper"])
        drawn = figures.draw(self.work)
        upright = panel(drawn[9], "(c)").collections[2].get_offsets()
        self.assertEqual(len(upright), len(wall))
        np.testing.assert_allclose(upright[:, 1], 5, atol=1e-5)
        self.assertIsNotNone(panel(drawn[6], "lidar, from above"))

    def test_no_input_is_a_street(self):
        out = self.work / "out"
        code, said = self.made("--frames", "0:0", "--out", out)
        self.assertEqual(code, 0, said)
        names = sorted(path.name for path in out.iterdir())
        self.assertEqual(names, [f"figure_{number}.png" for number in (1, 2, 3, 4, 6, 7, 8)])
        for name in names:
            image = figures.matplotlib.image.imread(out / name)
            self.assertGreater(min(image.shape[:2]), 300, name)
            self.assertGreater(len(np.unique(image)), 20, name)

    def test_faults_are_named(self):
        code, said = self.made(self.work / "nothing", "--out", self.work / "out")
        self.assertEqual((code, "nothing" in said), (65, True))
        self.assertEqual(self.made()[0], 2)
        code, said = self.made(small("street", "&frames=1&pitch_deg=3"), "--out", self.work / "out")
        self.assertEqual((code, "a level camera" in said), (1, True), said)
        (self.work / "file").write_text("not a folder")
        with self.assertRaisesRegex(run_folder.Fault, "file/out: cannot be written"):
            figures.save({}, self.work / "file" / "out")


class Panels(unittest.TestCase):
    def overlaid(self, occupancy, roll=0.0):
        """On a grey image of the paper's camera, 1.4 m above the road."""
        run = SimpleNamespace(rig=RIG, disparities=64, bins={"obstacle_height_m": 1.8, "follow_roll": roll != 0})
        ground = {"height_m": 1.4, "pitch_rad": 0, "roll_rad": roll}
        return panels.overlaid(np.full((320, 512), 0.5), occupancy, run, ground)

    def coloured(self, picture, colour, column):
        """First and last row of the column that have the colour; the rows between have it, too."""
        rows = np.nonzero(np.abs(picture[:, column] - 0.25 - 0.5 * np.array(colour)).max(axis=1) < 1e-6)[0]
        self.assertEqual(len(rows), rows[-1] - rows[0] + 1)
        return rows[0], rows[-1]

    def test_what_is_upright_is_a_red_slab_and_free_road_is_blue(self):
        occupancy = np.full((64, 512), 0.5)
        occupancy[10, 100], occupancy[10, 101], occupancy[20, 102] = 0.76, 0.74, 0.1
        occupancy[1:10, 100] = 0.1  # free road behind the slab, which hides it
        picture = self.overlaid(occupancy)
        # from the foot, row 160 + 10·1.4/0.22, up by 10·1.8/0.22 rows
        self.assertEqual(self.coloured(picture, panels.UPRIGHT, 100), (142, 223))
        # road of the disparities 19.5 to 20.5
        self.assertEqual(self.coloured(picture, panels.ROAD, 102), (285, 290))
        np.testing.assert_allclose(picture[224:, 100], 0.5)
        np.testing.assert_allclose(np.delete(picture, (100, 102), axis=1), 0.5)

    def test_slabs_follow_the_roll(self):
        occupancy = np.full((64, 512), 0.5)
        occupancy[10, (156, 356)] = 0.9
        picture = self.overlaid(occupancy, roll=0.1)  # right side down: the road is higher there
        (left, _), (right, _) = (self.coloured(picture, panels.UPRIGHT, column) for column in (156, 356))
        self.assertAlmostEqual(left - right, 200 * np.tan(0.1), delta=1.01)

    def test_a_lidar_return_lies_where_it_is_in_the_vehicle_frame(self):
        def at(pitch):
            run = SimpleNamespace(ground={"height_m": 1.65, "pitch_rad": pitch, "roll_rad": 0})
            return run_folder.Run.in_vehicle(run, [[-2, 1.15, 10]])[0]

        np.testing.assert_allclose(at(0), [10, 2, 0.5])
        # in the frame of a camera pitched downwards the road rises ahead
        self.assertAlmostEqual(at(0.01)[2], 1.65 - np.cos(0.01) * 1.15 - np.sin(0.01) * 10)


if __name__ == "__main__":
    unittest.main()
