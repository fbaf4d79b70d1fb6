#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Geometry of the paper's figures."""
import unittest
from types import SimpleNamespace

import figures_support  # noqa: F401 (first)
import numpy as np

import panels
import run_folder

RIG = SimpleNamespace(width_px=512, height_px=320, focal_px=410, cx_px=256, cy_px=160, baseline_m=0.22)


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
