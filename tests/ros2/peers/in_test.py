# SPDX-License-Identifier: Apache-2.0
"""Images, CameraInfo, depth, odometry and /clock of nodes of ROS 2, as the tool receives them."""
import time
import unittest

from support import BEST_EFFORT, LATCHED, RELIABLE, Cameras, Tool, spin_until, stamp_ns  # before rclpy

import numpy as np
import rclpy
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import CompressedImage, Image
from stereo_msgs.msg import DisparityImage

PERIOD_S = 0.05


def rvl_of(shape, value):
    """Encode an image of one value as compressed_depth_image_transport does."""
    def nibbles(number):
        return [number & 7 | 8, *nibbles(number >> 3)] if number > 7 else [number]
    count = shape[0] * shape[1]
    code = nibbles(0) + nibbles(count) + nibbles(2 * value) + [0] * (count - 1)
    words = np.array(code + [0] * (-len(code) % 8), np.uint32).reshape(-1, 8) @ (1 << np.arange(28, -1, -4, np.uint32))
    return bytes(12) + np.array([shape[1], shape[0], *words], np.uint32).tobytes()


class In(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        rclpy.init()
        cls.node = rclpy.create_node('cameras')

    @classmethod
    def tearDownClass(cls):
        rclpy.shutdown()

    def grids_of(self, name):
        grids = []
        self.node.create_subscription(OccupancyGrid, f'/{name}/occupancy_grid', grids.append, LATCHED)
        return grids

    def send_until(self, condition, senders, begin_ns=None, seconds=15.0):
        """Call senders with stamps that grow; returns whether the condition has become true."""
        begin_ns = time.time_ns() if begin_ns is None else begin_ns
        begun = time.monotonic()
        while not condition():
            now = time.monotonic() - begun
            if now > seconds:
                return False
            for send in senders:
                send(begin_ns + int(now * 1e9))
            spin_until(self.node, lambda: False, PERIOD_S)
        return True

    def test_pairs_of_two_cameras_in_two_namespaces(self):
        front = Cameras(self.node, '/front', RELIABLE)
        rear = Cameras(self.node, '/rear', BEST_EFFORT, 'rgb8')
        grids = [self.grids_of('front_grid'), self.grids_of('rear_grid')]
        with Tool('live', 'ros2:/front', '--poses', '/front/odom', '--ros2-camera-at', '0,0,0', '--ros2',
                  '--ros2-node', 'front_grid', '--listen', ':0') as first, Tool(
                      'live', 'ros2:/rear', '--poses', 'none', '--ros2', '--ros2-node', 'rear_grid', '--listen',
                      ':0') as second:
            done = self.send_until(lambda: min(map(len, grids)) >= 5, [front.send, rear.send])
            logs = first.end() + second.end()
        self.assertTrue(done, logs)
        for cameras, received in zip((front, rear), grids):
            for grid in received:
                self.assertIn(stamp_ns(grid), cameras.sent)
        # the first is in the frame of the odometry, which moves along x
        self.assertGreater(grids[0][-1].info.origin.position.x + 1e-9, grids[0][0].info.origin.position.x)

    def test_localhost_only(self):
        """ROS_LOCALHOST_ONLY=1 is the range LOCALHOST of this process."""
        cameras = Cameras(self.node, '/local')
        grids = self.grids_of('local_grid')
        environment = {'ROS_LOCALHOST_ONLY': '1', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}
        with Tool('live', 'ros2:/local', '--poses', 'none', '--ros2', '--ros2-node', 'local_grid', '--listen', ':0',
                  **environment) as tool:
            done = self.send_until(lambda: len(grids) >= 3, [cameras.send])
            log = tool.end()
        self.assertTrue(done, log)

    def test_depth_and_disparities(self):
        for kind in ('16UC1', '32FC1', 'compressedDepth', 'disparity'):
            with self.subTest(kind):
                at = f'/camera_{kind.lower()}'
                cameras = Cameras(self.node, at)
                self.node.destroy_publisher(cameras.images.pop())
                self.node.destroy_publisher(cameras.infos.pop())
                sender = self.depth_sender(cameras, at, kind)
                name = f'grid_{kind.lower()}'
                grids = self.grids_of(name)
                with Tool('live', f'ros2:{at}', '--poses', 'none', '--ros2', '--ros2-node', name, '--listen',
                          ':0') as tool:
                    done = self.send_until(lambda: len(grids) >= 3, [sender])
                    log = tool.end()
                self.assertTrue(done, log)

    def depth_sender(self, cameras, at, kind):
        depth_m = cameras.FOCAL * cameras.BASELINE / cameras.SHIFT
        message_type, topic = {'disparity': (DisparityImage, 'disparity'),
                               'compressedDepth': (CompressedImage, 'depth/image_rect/compressedDepth')
                               }.get(kind, (Image, 'depth/image_rect'))
        publisher = self.node.create_publisher(message_type, f'{at}/{topic}', 10)
        half = rvl_of((cameras.HEIGHT // 2, cameras.WIDTH // 2), round(depth_m * 1000))
        pattern = np.random.default_rng(2).integers(0, 256, (cameras.HEIGHT, cameras.WIDTH), dtype=np.uint8)

        def image_of(values, encoding, stamp):
            image = Image(height=cameras.HEIGHT, width=cameras.WIDTH, encoding=encoding,
                          step=values.nbytes // cameras.HEIGHT)
            image.header.stamp, image.header.frame_id = stamp, 'left_optical'
            image.data.frombytes(values.tobytes())
            return image

        def send(ns):
            stamp = rclpy.time.Time(nanoseconds=ns).to_msg()
            cameras.images[0].publish(image_of(pattern, 'mono8', stamp))
            cameras.infos[0].publish(cameras.info(stamp, 0))
            shape = (cameras.HEIGHT, cameras.WIDTH)
            if kind == '16UC1':
                publisher.publish(image_of(np.full(shape, round(depth_m * 1000), np.uint16), '16UC1', stamp))
            elif kind == '32FC1':
                publisher.publish(image_of(np.full(shape, depth_m, np.float32), '32FC1', stamp))
            elif kind == 'compressedDepth':
                message = CompressedImage(format='16UC1; compressedDepth rvl', data=half)
                message.header.stamp, message.header.frame_id = stamp, 'left_optical'
                publisher.publish(message)
            else:
                message = DisparityImage(f=cameras.FOCAL, t=cameras.BASELINE, min_disparity=0.0, max_disparity=64.0,
                                         image=image_of(np.full(shape, cameras.SHIFT, np.float32), '32FC1', stamp))
                message.header = message.image.header
                publisher.publish(message)
        return send

    def test_chain_of_transforms(self):
        """Another process of the tool publishes odom → base_link and, latched, base_link → stereo_left_optical."""
        cameras = Cameras(self.node, '/tracked', frame='stereo_left_optical')
        grids, observed = self.grids_of('tf_grid'), []
        self.node.create_subscription(OccupancyGrid, '/tf_grid/observed_grid', observed.append, LATCHED)
        with Tool('live', 'scene:street?width=192&height=128&frames=60', '--loop', '--ros2', '--ros2-node', 'robot',
                  '--listen', ':0'), Tool('live', 'ros2:/tracked', '--poses', 'tf', '--ros2', '--ros2-node', 'tf_grid',
                                          '--listen', ':0') as tool:
            # stamps of two seconds ago: on a busy machine the other process is late
            done = self.send_until(lambda: len(grids) >= 10, [lambda ns: cameras.send(ns - 2 * 10**9)], seconds=20)
            log = tool.end()
        self.assertTrue(done, log)
        self.assertIn('extrinsics of TF (base_link → stereo_left_optical)', log)
        self.assertIn('poses of the camera: stereo_left_optical in odom', log)
        self.assertIn('another node publishes the transform base_link → stereo_left_optical', log)
        self.assertNotIn('odom → stereo_grid is not published', log)
        self.assertEqual(observed[-1].header.frame_id, 'stereo_grid')
        self.assertGreater(len({grid.info.origin.position.x for grid in grids}), 1)  # it follows

    def test_simulated_time_that_jumps_back(self):
        cameras = Cameras(self.node, '/simulated')
        grids = self.grids_of('sim_grid')
        with Tool('live', 'ros2:/simulated', '--poses', '/simulated/odom', '--ros2-camera-at', '0,0,0', '--ros2',
                  '--ros2-node', 'sim_grid', '--ros2-sim-time', '--listen', ':0') as tool:
            first = self.send_until(lambda: len(grids) >= 3, [cameras.send], 1000 * 10**9)
            before = len(grids)
            again = self.send_until(lambda: len(grids) >= before + 3, [cameras.send], 500 * 10**9)
            log = tool.end()
        self.assertTrue(first and again, log)
        self.assertIn('/clock steps back', log)
        self.assertLess(stamp_ns(grids[-1]), 600 * 10**9)


if __name__ == '__main__':
    unittest.main(verbosity=2)
