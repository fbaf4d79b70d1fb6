#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Latency, loss and CPU of ROS 2's messages between two processes of this machine, as Markdown.

dds.py BIN SECONDS [ROS...]: BIN is the folder of a build with STEREOGRID_TESTS and STEREOGRID_BENCH. 400 x 400 grids at
20 Hz from libstereogrid_dds.so to a bare participant of Cyclone DDS and one of Fast DDS; pairs of 1242 x 375 px at 20 Hz
the other way. ROS are environments with rclpy, such as build/ros/jazzy; their nodes do the same with Fast DDS, and receive
grids of 0.47 and 1.9 MB at 10 Hz, as large as disparities, in our fragments and in those that Cyclone DDS makes by itself.
dds.py node map|large|pairs SECONDS: such a node.
"""
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

HZ = 20
CELLS = 400
LARGE_HZ = 10
LARGE_CELLS = {683: "0.47 MB", 1366: "1.9 MB"}
SIZE = "1242x375"
HANGS_S = 40
LOOPBACK = ('<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>')


BARE = {"CYCLONEDDS_URI": LOOPBACK}
SMALL_FRAGMENTS = {"CYCLONEDDS_URI": "<CycloneDDS><Domain><General><FragmentSize>1344B</FragmentSize></General></Domain>"
                                     "</CycloneDDS>"}
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


class Part:
    """A process, what it says, and the CPU that it takes."""

    def __init__(self, *words, env):
        self.file = tempfile.TemporaryFile("w+")
        self.begun = time.monotonic()
        self.process = subprocess.Popen([str(word) for word in words], stdout=self.file,
                                        env=os.environ | {"ROS_DOMAIN_ID": "99"} | env)

    def end(self) -> tuple:
        timer = threading.Timer(HANGS_S, self.process.kill)  # a reader of Fast DDS may loop without end
        timer.start()
        _, _, usage = os.wait4(self.process.pid, 0)
        timer.cancel()
        cpu = 100 * (usage.ru_utime + usage.ru_stime) / (time.monotonic() - self.begun)
        self.file.seek(0)
        return self.file.read(), cpu


def percentile(sorted_values: list, share: float) -> float:
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]


def row(what: str, sent: str, topics: int, received: str, ours: float, theirs: float) -> None:
    """`sent`: stamps before the first received one do not count, since the sender does not wait for the peer."""
    times = [(int(stamp), int(at)) for stamp, at in re.findall(r"^\w+ (\d+).* at (\d+)$", received, re.M)]
    stamps = [int(stamp) for stamp in re.findall(r"^\w+ (\d+)$", sent, re.M)]
    count = topics * sum(not times or stamp >= min(times)[0] for stamp in stamps)
    latency_ms = sorted((at - stamp) / 1e6 for stamp, at in times)
    shown = [f"{percentile(latency_ms, share):.2f}" if times else "–" for share in (0.5, 0.99)]
    print(f"| {what} | {count} | {count - len(times)} | {' | '.join(shown)} | {ours:.1f} | {theirs:.1f} |", flush=True)


def ros_node(ros: Path, what: str, seconds: int) -> Part:
    env = {"AMENT_PREFIX_PATH": str(ros), "LD_LIBRARY_PATH": str(ros / "lib"), "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}
    return Part(ros / "bin/python", "-u", __file__, "node", what, seconds, env=LOCAL | env)


def grids(folder: Path, what: str, reader: Part, env: dict, seconds: int, topic="/map", cells=CELLS, hz=HZ) -> None:
    time.sleep(0.5)
    sender = Part(folder / "bench_dds", folder / "libstereogrid_dds.so", "send", topic, cells, hz, seconds, env=env)
    sent, ours = sender.end()
    received, theirs = reader.end()
    row(f"grids to {what}", sent, 1, received, ours, theirs)


def pairs(folder: Path, what: str, start, env: dict, seconds: int) -> None:
    reader = Part(folder / "bench_dds", folder / "libstereogrid_dds.so", "receive", "/stereo", seconds + 12, env=env)
    time.sleep(1)
    sender = start()
    sent, theirs = sender.end()
    received, ours = reader.end()
    row(f"images from {what}", sent, 2, received, ours, theirs)


def node(what: str, seconds: int) -> None:
    import rclpy
    from nav_msgs.msg import OccupancyGrid
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from sensor_msgs.msg import Image
    rclpy.init()
    made = rclpy.create_node("peer")
    if what != "pairs":
        def show(grid: OccupancyGrid) -> None:
            print(f"grid {grid.header.stamp.sec * 10**9 + grid.header.stamp.nanosec} at {time.time_ns()}")
        qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL) if what == "map" else QoSProfile(depth=10)
        made.create_subscription(OccupancyGrid, f"/{what}", show, qos)
        end = time.monotonic() + seconds + 4
        while time.monotonic() < end:
            rclpy.spin_once(made, timeout_sec=0.1)
        return
    width, height = (int(number) for number in SIZE.split("x"))
    image = Image(width=width, height=height, step=width, encoding="mono8")
    image.data.frombytes(bytes(width * height))
    cameras = [made.create_publisher(Image, f"/stereo/{side}/image_rect", 5) for side in ("left", "right")]
    for _ in range(HZ * seconds):
        time.sleep(1 / HZ)
        stamp_ns = time.time_ns()
        image.header.stamp.sec, image.header.stamp.nanosec = divmod(stamp_ns, 10**9)
        for camera in cameras:
            camera.publish(image)
        print(f"pair {stamp_ns}")


def main() -> None:
    if sys.argv[1] == "node":
        return node(sys.argv[2], int(sys.argv[3]))
    folder, seconds, systems = Path(sys.argv[1]), int(sys.argv[2]), [Path(name) for name in sys.argv[3:]]
    print("| what | sent | lost | latency, median ms | 99 % ms | CPU of ours, % of a core | of the peer |\n"
          "|---|---|---|---|---|---|---|")
    for qos in (("reliable", "transient_local"), ("best_effort", "volatile")):
        for peer in ("bare", "fast"):
            reader = Part(folder / f"stereogrid_{peer}_peer", "grids", "rt/map", *qos, HZ * seconds, seconds + 4, env=BARE)
            grids(folder, f"{peer}, {qos[0]}", reader, BARE, seconds)
    for ros in systems:
        grids(folder, f"rclpy of {ros.name}, reliable", ros_node(ros, "map", seconds), LOCAL, seconds)
        for cells, size in LARGE_CELLS.items():
            for fragments, env in (("", LOCAL), (", fragments of 1344 B", LOCAL | SMALL_FRAGMENTS)):
                grids(folder, f"rclpy of {ros.name}, {size}, reliable{fragments}", ros_node(ros, "large", seconds), env,
                      seconds, "/large", cells, LARGE_HZ)
    for reliability in ("best_effort", "reliable"):
        pairs(folder, f"bare, {reliability}",
              lambda: Part(folder / "stereogrid_bare_peer", "pairs", "/stereo", reliability, SIZE, HZ, seconds, env=BARE),
              BARE, seconds)
    for ros in systems:
        pairs(folder, f"rclpy of {ros.name}, reliable", lambda: ros_node(ros, "pairs", seconds), LOCAL, seconds)


if __name__ == "__main__":
    main()
