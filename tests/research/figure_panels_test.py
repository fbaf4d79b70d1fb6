#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""The panels of the paper's figures, on numbers that are known."""
import unittest
from types import SimpleNamespace

import figures_support  # noqa: F401 (first)
import numpy as np
import stereogrid
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import figures
import panels
import run_folder

PAPER = {"false_positive": 0.02, "false_negative": 0.02, "tau_obstacle": 0.1, "tau_road": 0.1}
RIG = SimpleNamespace(width_px=512, height_px=320, focal_px=410, cx_px=256, cy_px=160, baseline_m=0.22)
FOUR_BY_EIGHT = SimpleNamespace(rig=RIG, grid=stereogrid.GridGeometry(0, -2, 0.5, 4, 8), disparities=8)


def pixels(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3] / 255


def colours_at(draw, places):
    """Colours (R G B) at places (x m ahead, y m to the left) of a panel as it is drawn."""
    figure = Figure(figsize=(8, 8))
    axes = figure.add_subplot()
    draw(axes)
    image = pixels(figure)
    at = axes.transData.transform([(y, x) for x, y in places])
    return [tuple(image[int(len(image) - row), int(column)]) for column, row in at]


def centre(ix, iy):
    """Position of a cell of FOUR_BY_EIGHT, a little aside so that no ruler runs through it."""
    return 0.5 * ix + 0.2, -2 + 0.5 * iy + 0.2


class Panels(unittest.TestCase):
    def assert_colour(self, got, expected):
        np.testing.assert_allclose(got, to_rgb(expected), atol=0.02)

    def test_ahead_is_up_and_left_is_left(self):
        occupancy = np.zeros((8, 4))
        occupancy[7, 3] = 1  # farthest, leftmost
        figure = Figure()
        axes = figure.add_subplot()
        panels.grid(axes, occupancy, FOUR_BY_EIGHT, "")
        image = pixels(figure)
        box = axes.get_window_extent()
        top, left, right = int(len(image) - box.y1), int(box.x0), int(box.x1)
        np.testing.assert_allclose(image[top + 6, left + 6], 0, atol=0.02)
        np.testing.assert_allclose(image[top + 6, right - 6], 1, atol=0.02)
        self.assertEqual(axes.get_xlim(), (2, -2))
        self.assertEqual(axes.get_ylim(), (0, 2))

    def test_lidar_returns_are_coloured_by_height(self):
        points = np.array([[*centre(0, 6), 0.1], [*centre(2, 6), 1], [*centre(2, 0), 2.5], [40, 0, 1]])

        def draw(axes):
            panels.scan(axes, points, FOUR_BY_EIGHT, "")
            for collection in axes.collections:
                collection.set_sizes([99])

        upright, low, high, none = colours_at(draw, [centre(2, 6), centre(0, 6), centre(2, 0), centre(3, 7)])
        for got, (expected, _) in zip((upright, low, high), panels.SCAN_COLOURS):
            self.assert_colour(got, expected)
        self.assert_colour(none, "white")

    def test_truth_separates_seen_from_hidden(self):
        state, occupied = np.ones((8, 4), int), np.zeros((8, 4), int)
        state[7, 1], state[7, 2], state[7, 3] = 2, 0, 0
        occupied[7, 1] = occupied[7, 2] = 1
        known = SimpleNamespace(state=state, occupied=occupied)
        got = colours_at(lambda axes: panels.truth(axes, known, FOUR_BY_EIGHT, ""),
                         [centre(1, 7), centre(2, 7), centre(0, 7), centre(3, 7)])
        for colour, (expected, _) in zip(got, panels.TRUTH_COLOURS):
            self.assert_colour(colour, expected)

    def test_counts_are_logarithmic(self):
        values = np.zeros((8, 4), int)
        values[3, 1] = 99
        figure = Figure()
        axes = figure.add_subplot()
        panels.counts(axes, values, FOUR_BY_EIGHT, "")
        norm = axes.images[0].norm
        np.testing.assert_allclose([norm(0), norm(9), norm(99)], [0, 0.5, 1], atol=1e-9)

    def test_distances_belong_to_their_disparities(self):
        figure = Figure()
        axes = figure.add_subplot()
        panels.probabilities(axes, np.zeros((64, 512)), SimpleNamespace(rig=RIG, disparities=64), "", "P")
        right = figure.axes[1]
        self.assertEqual(right.get_ylim(), (63.5, -0.5))
        marks = {text.get_text(): at for text, at in zip(right.get_yticklabels(), right.get_yticks())}
        self.assertAlmostEqual(marks["2 m"], 410 * 0.22 / 2)
        self.assertNotIn("1 m", marks)  # beyond the last disparity
        self.assertNotIn("50 m", marks)  # too close to 20 m

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

    def test_the_formulas_are_drawn(self):
        first = figures.figure_1(PAPER)
        drawn = first.axes[1].images[0].get_array()  # rows: r_O, columns: visibility
        np.testing.assert_allclose([drawn[0, 0], drawn[-1, -1], drawn[0, -1], drawn[-1, 150]], [0.5, 0.98, 0.02, 0.74],
                                   atol=1e-4)
        np.testing.assert_allclose(drawn[30, -1], 0.98 - 0.96 * np.exp(-1))  # r_O = tau_O
        with figures.matplotlib.rc_context(figures.STYLE):
            second = figures.figure_2(PAPER)
        curve = next(line for line in second.axes[0].lines if line.get_label() == "tau_O = 0.1, as set")
        np.testing.assert_allclose(curve.get_ydata()[50], 1 - np.exp(-1))  # at r_O = 0.1
        road, total = (next(axes for axes in second.axes if axes.get_title(loc="left").startswith(letter)).images[0]
                       for letter in ("(b)", "(d)"))
        self.assertEqual(tuple(road.get_extent()), (0, 0.3, 0.5, 1))
        np.testing.assert_allclose(road.get_array()[-1, [0, 100]], [1, np.exp(-1)])
        np.testing.assert_allclose(total.get_array()[[0, 150, -1], [150, 150, -1]], [0.5, 0.25, 0.02])


if __name__ == "__main__":
    unittest.main()
