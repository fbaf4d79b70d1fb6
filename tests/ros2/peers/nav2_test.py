# SPDX-License-Identifier: Apache-2.0
"""Grids of examples/python/nav2.py, as a node of ROS 2 receives them."""
import signal
import subprocess
import sys
import unittest
from pathlib import Path

from support import LATCHED, spin_until, stamp_ns  # before rclpy

import numpy as np
import rclpy
from nav_msgs.msg import OccupancyGrid

import stereogrid as sg

EXAMPLE = Path(__file__).parents[3] / 'examples/python/nav2.py'
SCENE = 'scene:street?width=192&height=128&frames=8'


class Nav2(unittest.TestCase):

    def test_cells(self):
        rclpy.init()
        self.addCleanup(rclpy.shutdown)
        node = rclpy.create_node('static_layer')
        received = []
        node.create_subscription(OccupancyGrid, '/grid', received.append, LATCHED)
        recording = sg.open(SCENE)
        pipeline = sg.Pipeline(sg.preset('default'), recording.rig)
        expected = {result.stamp_ns: result.world for result in map(pipeline.process, recording)}
        with subprocess.Popen([sys.executable, EXAMPLE, SCENE, '/grid']) as example:
            self.assertTrue(spin_until(node, lambda: any(stamp_ns(one) == max(expected) for one in received)))
            example.send_signal(signal.SIGINT)
        self.assertEqual(example.returncode, 0)
        for one in received:
            world = expected[stamp_ns(one)]
            self.assertEqual(one.header.frame_id, 'odom')
            origin = one.info.origin.position
            np.testing.assert_allclose((one.info.resolution, origin.x, origin.y),
                                       (world.grid.cell_size_m, world.grid.x_min_m, world.grid.y_min_m), rtol=1e-6)
            self.assertTrue((origin.x / one.info.resolution).is_integer())
            cells = np.array(one.data, np.int8).reshape(one.info.height, one.info.width)
            np.testing.assert_array_equal(cells, sg.occupancy_values(world.occupancy, 'nav2'))
            self.assertTrue((cells == 100).any() and (cells == 0).any() and (cells == -1).any())


if __name__ == '__main__':
    unittest.main(verbosity=2)
