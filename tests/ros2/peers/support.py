# SPDX-License-Identifier: Apache-2.0
"""Nodes of ROS 2 (rclpy with Fast DDS) beside the tool, on this machine only."""
import faulthandler
import json
import os
import signal
import socket
import subprocess
import tempfile
import time
from pathlib import Path

held = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)


def own_domain():
    """Return a domain from 101 to 200 that no other process of tests holds, until this process ends."""
    for tried in range(100):
        domain = 101 + (os.getpid() + tried) % 100
        try:
            held.bind(f'\0stereogrid-domain-{domain}')
            return domain
        except OSError:
            continue
    raise RuntimeError('100 processes of tests hold all domains')


# before rclpy is loaded
os.environ.update(RMW_IMPLEMENTATION='rmw_fastrtps_cpp', ROS_DOMAIN_ID=str(own_domain()),
                  ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST')
for name in ('ROS_DISTRO', 'ROS_LOCALHOST_ONLY', 'ROS_STATIC_PEERS', 'CYCLONEDDS_URI'):
    os.environ.pop(name, None)

import numpy as np
import rclpy
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image

LATCHED = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
RELIABLE = QoSProfile(depth=10)
BEST_EFFORT = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
HANG_S = 20
SHARE = Path(os.environ['AMENT_PREFIX_PATH']) / 'share'


def message_class(type_name):
    """Return the class of "sensor_msgs/msg/Image"; None where its package is not on PyPI."""
    package, _, name = type_name.split('/')
    try:
        return getattr(__import__(package + '.msg', fromlist=[name]), name)
    except (ModuleNotFoundError, AttributeError):
        return None


def hash_of(type_name):
    """Return the hash that ROS's own package has of its type."""
    package, _, name = type_name.split('/')
    described = json.loads((SHARE / package / 'msg' / (name + '.json')).read_text())
    return next(one['hash_string'] for one in described['type_hashes'] if one['type_name'] == type_name)


class Tool:
    """The tool as a process; its output goes to a file."""

    def __init__(self, *words, **environment):
        self.log = tempfile.NamedTemporaryFile(prefix='stereogrid_', suffix='.log')
        self.process = subprocess.Popen(['setpriv', '--pdeathsig', 'KILL', os.environ['STEREOGRID_TOOL'], *words],
                                        stdout=self.log, stderr=subprocess.STDOUT, env={**os.environ, **environment})

    def end(self):
        """End it as Ctrl-C does; returns its output."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(20)
        return Path(self.log.name).read_text()

    def __enter__(self):
        return self

    def __exit__(self, *ignored):
        self.end()


def spin_until(node, condition, seconds=20.0):
    """Return whether the condition has become true."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            return False
        faulthandler.dump_traceback_later(HANG_S, exit=True)  # peers.sh repeats a test whose peer hangs
        rclpy.spin_once(node, timeout_sec=0.05)
        faulthandler.cancel_dump_traceback_later()
    return True


def stamp_ns(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


class Cameras:
    """Two cameras with 8 px of disparity, 0.25 m apart, /clock and odometry at 2 m/s along x."""

    WIDTH, HEIGHT, SHIFT, FOCAL, BASELINE = 256, 160, 8, 100.0, 0.25

    def __init__(self, node, at, qos=RELIABLE, encoding='mono8', frame='left_optical'):
        self.node, self.at, self.encoding, self.frame = node, at, encoding, frame
        self.images = [node.create_publisher(Image, f'{at}/{side}/image_rect', qos) for side in ('left', 'right')]
        self.infos = [node.create_publisher(CameraInfo, f'{at}/{side}/camera_info', qos) for side in ('left', 'right')]
        self.odometry = node.create_publisher(Odometry, f'{at}/odom', qos)
        self.clock = node.create_publisher(Clock, '/clock', qos)
        self.random = np.random.default_rng(1)
        self.sent = []

    def send(self, ns):
        """Publish a pair of that instant, and all that belongs to it."""
        stamp = rclpy.time.Time(nanoseconds=ns).to_msg()
        self.clock.publish(Clock(clock=stamp))
        odometry = Odometry()
        odometry.header.stamp, odometry.header.frame_id, odometry.child_frame_id = stamp, 'odom', 'base_link'
        odometry.pose.pose.position.x = 2e-9 * (ns % 10**12)
        self.odometry.publish(odometry)
        pattern = self.random.integers(0, 256, (self.HEIGHT, self.WIDTH + self.SHIFT), dtype=np.uint8)
        for i in (0, 1):
            pixels = pattern[:, i * self.SHIFT:i * self.SHIFT + self.WIDTH]
            if self.encoding == 'rgb8':
                pixels = np.repeat(pixels[:, :, None], 3, axis=2)
            image = Image(height=self.HEIGHT, width=self.WIDTH, encoding=self.encoding,
                          step=pixels.nbytes // self.HEIGHT)
            image.header.stamp, image.header.frame_id = stamp, self.frame
            image.data.frombytes(np.ascontiguousarray(pixels).tobytes())
            self.images[i].publish(image)
            self.infos[i].publish(self.info(stamp, i))
        self.sent.append(ns)

    def info(self, stamp, i):
        f, u, v = self.FOCAL, self.WIDTH / 2, self.HEIGHT / 2
        info = CameraInfo(height=self.HEIGHT, width=self.WIDTH, distortion_model='plumb_bob', d=[0.0] * 5,
                          k=[f, 0.0, u, 0.0, f, v, 0.0, 0.0, 1.0], r=[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                          p=[f, 0.0, u, -i * f * self.BASELINE, 0.0, f, v, 0.0, 0.0, 0.0, 1.0, 0.0])
        info.header.stamp, info.header.frame_id = stamp, self.frame
        return info
