#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Grids of a drive for Nav2: nav2.py DRIVE [TOPIC]

A nav2_costmap_2d::StaticLayer reads them with map_topic TOPIC, map_subscribe_transient_local true and trinary_costmap
false, in a costmap whose global_frame is odom. /tf comes from the robot. The last grid is published until Ctrl-C.
"""

import array
import sys
from contextlib import suppress

import numpy as np
import rclpy
from nav_msgs.msg import OccupancyGrid
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time

import stereogrid as sg


def message_of(result: sg.FrameResult) -> OccupancyGrid:
    """Returns the grid in the world frame."""
    grid = result.world.grid
    message = OccupancyGrid()
    message.header.frame_id = "odom"
    message.header.stamp = message.info.map_load_time = Time(nanoseconds=result.stamp_ns).to_msg()
    message.info.resolution = cell_size_m = float(np.float32(grid.cell_size_m))
    message.info.width, message.info.height = grid.nx, grid.ny
    # a whole number of the message's cells from the origin
    message.info.origin.position.x = round(grid.x_min_m / grid.cell_size_m) * cell_size_m
    message.info.origin.position.y = round(grid.y_min_m / grid.cell_size_m) * cell_size_m
    message.data = array.array("b", sg.occupancy_values(result.world.occupancy, "nav2").tobytes())
    return message


def main() -> None:
    rclpy.init()
    node = rclpy.create_node("stereo_grid")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    publisher = node.create_publisher(OccupancyGrid, (sys.argv[2:] or ["/stereo_grid/occupancy_grid"])[0], latched)
    recording = sg.open(sys.argv[1])
    pipeline = sg.Pipeline(sg.preset("default"), recording.rig, stages=False)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        for frame in recording:
            publisher.publish(message_of(pipeline.process(frame)))
        rclpy.spin(node)


if __name__ == "__main__":
    main()
