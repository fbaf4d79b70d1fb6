#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Memory of `stereogrid live ros2:… --ros2` while nodes of ROS 2 come and go, as Markdown.

visitors.py STEREOGRID ROS SECONDS: ROS is an environment with rclpy, such as build/ros/jazzy. Its nodes are a camera
(5 Hz), which is killed and started again every ten minutes, and visitors, a new one every 6 s: they subscribe until each
topic has come, then two of three leave, the others are killed, half of these after they were stopped for 5 s. Memory
that is not of files, threads and open files of the tool are sampled every 10 s; the first five minutes do not count.
visitors.py node camera|visitor: such a node.
"""
import os
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HZ = 5
TOPICS = {"occupancy_grid": "OccupancyGrid", "points": "PointCloud2", "disparity": "DisparityImage",
          "obstacle_markers": "MarkerArray", "status": "DiagnosticArray"}
VISIT_EVERY_S = 6
VISIT_S = 15
CAMERA_EVERY_S = 600
SAMPLE_EVERY_S = 10
ROW_S = 300


def camera() -> None:
    sys.path.insert(0, str(Path(__file__).parent.parent / "tests/ros2/peers"))
    domain = os.environ["ROS_DOMAIN_ID"]
    import support
    os.environ["ROS_DOMAIN_ID"] = domain
    support.rclpy.init()
    cameras = support.Cameras(support.rclpy.create_node("camera"), "/stereo")
    while True:
        time.sleep(1 / HZ)
        cameras.send(time.time_ns())


def visitor() -> None:
    import rclpy
    from diagnostic_msgs.msg import DiagnosticArray
    from nav_msgs.msg import OccupancyGrid
    from sensor_msgs.msg import PointCloud2
    from stereo_msgs.msg import DisparityImage
    from visualization_msgs.msg import MarkerArray
    types = {one.__name__: one for one in (DiagnosticArray, OccupancyGrid, PointCloud2, DisparityImage, MarkerArray)}
    rclpy.init()
    node = rclpy.create_node(f"visitor_{os.getpid()}")
    missing = set(TOPICS)
    for topic, name in TOPICS.items():
        node.create_subscription(types[name], f"/stereo_grid/{topic}", lambda _, topic=topic: missing.discard(topic), 10)
    begun = time.monotonic()
    while missing and time.monotonic() - begun < VISIT_S:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(f"{'served' if not missing else 'missing ' + ' '.join(sorted(missing))} {time.monotonic() - begun:.2f}", flush=True)
    signal.sigtimedwait([signal.SIGUSR1], 60)
    rclpy.shutdown()


class Visit:
    """A visitor, and its end."""

    def __init__(self, number: int, start):
        self.kind = ("leaves", "leaves", "killed", "leaves", "leaves", "hangs")[number % 6]
        self.process = start("visitor", stdout=subprocess.PIPE, text=True)
        os.set_blocking(self.process.stdout.fileno(), False)
        self.begun, self.stopped, self.result = time.monotonic(), None, ""

    def is_over(self) -> bool:
        line = self.process.stdout.readline()
        if line.startswith(("served", "missing")):  # Fast DDS logs there, too
            self.result = line
        if not self.result and time.monotonic() - self.begun < 2 * VISIT_S:
            return False
        if self.kind == "hangs":
            if self.stopped is None:
                self.process.send_signal(signal.SIGSTOP)
                self.stopped = time.monotonic()
            if time.monotonic() - self.stopped < 5:
                return False
        if self.kind == "leaves" and self.stopped is None:
            self.process.send_signal(signal.SIGUSR1)
            self.stopped = time.monotonic()
        elif self.kind != "leaves" or time.monotonic() - self.stopped > VISIT_S:  # on a busy machine
            self.process.kill()
        return self.process.poll() is not None


def sample(process: int) -> tuple:
    status = Path(f"/proc/{process}/status").read_text()
    return (int(re.search(r"RssAnon:\s+(\d+)", status)[1]), int(re.search(r"Threads:\s+(\d+)", status)[1]),
            len(os.listdir(f"/proc/{process}/fd")))


def growth(points: list) -> float:
    """Slope of the line through points, kB a visitor."""
    return statistics.linear_regression(*zip(*points)).slope if len(points) > 1 else 0


def watch(tool: subprocess.Popen, seconds: int, start) -> None:
    begun = time.monotonic()
    cameras, visits, results, samples, all_samples = start("camera"), [], [], [], []
    begun_visits = begun_cameras = 0
    print("| minutes | visitors | served | memory, MB: least | most | threads, most | open files, most |\n|---|---|---|---|---|---|---|")
    next_visit, next_sample, next_camera, next_row = begun + 10, begun + SAMPLE_EVERY_S, begun + CAMERA_EVERY_S, begun + ROW_S
    while tool.poll() is None and time.monotonic() - begun <= seconds:
        time.sleep(0.2)
        now = time.monotonic()
        if now >= next_visit:
            visits.append(Visit(begun_visits, start))
            begun_visits, next_visit = begun_visits + 1, next_visit + VISIT_EVERY_S
        for visit in [one for one in visits if one.is_over()]:
            visits.remove(visit)
            results.append(visit.result or "none")
        if now >= next_camera:
            cameras.kill()
            cameras.wait()
            cameras, begun_cameras, next_camera = start("camera"), begun_cameras + 1, next_camera + CAMERA_EVERY_S
        if now >= next_sample:
            samples.append(sample(tool.pid))
            all_samples.append((now - begun, len(results), samples[-1][0]))
            next_sample += SAMPLE_EVERY_S
        if now >= next_row:
            memory_kb, threads, files = zip(*samples)
            served = sum(one.startswith("served") for one in results)
            print(f"{(now - begun) / 60:.0f} min: {min(memory_kb)} to {max(memory_kb)} kB", file=sys.stderr)
            print(f"| {(now - begun) / 60:.0f} | {len(results)} | {served} | {min(memory_kb) / 1000:.2f} | "
                  f"{max(memory_kb) / 1000:.2f} | {max(threads)} | {max(files)} |", flush=True)
            samples, next_row = [], next_row + ROW_S
    for one in (cameras, *(visit.process for visit in visits)):
        one.kill()
    if tool.poll() is not None:
        sys.exit("the tool has ended")
    waits_s = sorted(float(one.split()[-1]) for one in results if one.startswith("served"))
    if not waits_s:
        sys.exit(f"no visitor was served: {results}")
    settled = [(visitors, memory_kb) for since_s, visitors, memory_kb in all_samples if since_s > ROW_S]
    half = settled[len(settled) // 2:]
    print("\n| growth, kB a visitor | in the second half | cameras killed | until every topic has come, median s | most s |\n"
          "|---|---|---|---|---|\n"
          f"| {growth(settled):.2f} | {growth(half):.2f} | {begun_cameras} | {statistics.median(waits_s):.2f} | {waits_s[-1]:.2f} |")
    print("\nnot served:", [one for one in results if not one.startswith("served")], file=sys.stderr)


def main() -> None:
    if sys.argv[1] == "node":
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])
        return camera() if sys.argv[2] == "camera" else visitor()
    tool, ros, seconds = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3])
    env = os.environ | {"ROS_DOMAIN_ID": "98", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                        "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}
    of_ros = env | {"AMENT_PREFIX_PATH": str(ros), "LD_LIBRARY_PATH": str(ros / "lib")}

    def start(what: str, **options) -> subprocess.Popen:
        return subprocess.Popen([str(ros / "bin/python"), "-W", "ignore", __file__, "node", what], env=of_ros, **options)
    with tempfile.TemporaryFile("w+") as log:
        process = subprocess.Popen([tool, "live", "ros2:/stereo", "--poses", "none", "--ros2", "--threads", "1", "--listen", ":0"],
                                   stdout=log, stderr=log, env=env)
        try:
            watch(process, seconds, start)
        finally:
            process.terminate()
            process.wait()
            log.seek(0)
            print(log.read()[-2000:], file=sys.stderr)


if __name__ == "__main__":
    main()
