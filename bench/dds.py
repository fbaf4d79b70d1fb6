#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Latency, loss and CPU of ROS 2's messages between two processes of this machine, as Markdown.

dds.py BIN SECONDS: BIN is the folder of a build with STEREOGRID_TESTS and STEREOGRID_BENCH. 400 x 400 grids at 20 Hz from
libstereogrid_dds.so to a bare participant of Cyclone DDS and one of Fast DDS; pairs of 1242 x 375 px at 20 Hz the other way.
"""
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

HZ = 20
CELLS = 400
SIZE = "1242x375"
LOOPBACK = ('<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
            '<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>')


class Part:
    """A process, what it says, and the CPU that it takes."""

    def __init__(self, *words):
        self.file = tempfile.TemporaryFile("w+")
        self.begun = time.monotonic()
        self.process = subprocess.Popen([str(word) for word in words], stdout=self.file,
                                        env=os.environ | {"ROS_DOMAIN_ID": "99", "CYCLONEDDS_URI": LOOPBACK})

    def end(self) -> tuple:
        _, _, usage = os.wait4(self.process.pid, 0)
        cpu = 100 * (usage.ru_utime + usage.ru_stime) / (time.monotonic() - self.begun)
        self.file.seek(0)
        return self.file.read(), cpu


def percentile(sorted_values: list, share: float) -> float:
    return sorted_values[min(len(sorted_values) - 1, int(share * len(sorted_values)))]


def row(what: str, sent: int, received: str, ours: float, theirs: float) -> None:
    latency_ms = sorted((int(at) - int(stamp)) / 1e6 for stamp, at in re.findall(r"^\w+ (\d+).* at (\d+)$", received, re.M))
    if not latency_ms:
        sys.exit(f"{what}: nothing came")
    print(f"| {what} | {sent} | {sent - len(latency_ms)} | {percentile(latency_ms, 0.5):.2f} | "
          f"{percentile(latency_ms, 0.99):.2f} | {ours:.1f} | {theirs:.1f} |", flush=True)


def grids(folder: Path, peer: str, qos: tuple, seconds: int) -> None:
    reader = Part(folder / f"stereogrid_{peer}_peer", "grids", "rt/map", *qos, HZ * seconds, seconds + 4)
    time.sleep(0.5)
    sender = Part(folder / "bench_dds", folder / "libstereogrid_dds.so", "send", "/map", CELLS, HZ, seconds)
    sent, ours = sender.end()
    received, theirs = reader.end()
    row(f"grids to {peer}, {qos[0]}", int(sent.split()[1]), received, ours, theirs)


def pairs(folder: Path, reliability: str, seconds: int) -> None:
    reader = Part(folder / "bench_dds", folder / "libstereogrid_dds.so", "receive", "/stereo", seconds + 3)
    time.sleep(1)
    sender = Part(folder / "stereogrid_bare_peer", "pairs", "/stereo", reliability, SIZE, HZ, seconds)
    sent, theirs = sender.end()
    received, ours = reader.end()
    first = min(re.findall(r"image (\d+)", received))  # the camera does not wait until it is found
    stamps = [stamp for stamp in re.findall(r"pair (\d+)", sent) if stamp >= first]
    row(f"images from bare, {reliability}", 2 * len(stamps), received, ours, theirs)


def main() -> None:
    folder, seconds = Path(sys.argv[1]), int(sys.argv[2])
    print("| what | sent | lost | latency, median ms | 99 % ms | CPU of ours, % of a core | of the peer |\n"
          "|---|---|---|---|---|---|---|")
    for qos in (("reliable", "transient_local"), ("best_effort", "volatile")):
        for peer in ("bare", "fast"):
            grids(folder, peer, qos, seconds)
    for reliability in ("best_effort", "reliable"):
        pairs(folder, reliability, seconds)


if __name__ == "__main__":
    main()
