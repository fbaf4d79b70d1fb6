#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Hands image pairs to `stereogrid live shm:/NAME` through shared memory (docs/live.md). Needs numpy.

As a program: shared_pairs.py NAME WIDTH HEIGHT SECONDS sends 30 pairs of noise a second, shifted by 8 px.
"""
import mmap
import os
import struct
import sys
import time

import numpy as np

SLOTS = 4


class SharedPairs:
    """Pairs of uint8 images of shape (height, width)."""

    def __init__(self, name: str, width: int, height: int):
        self.path = "/dev/shm/" + name.strip("/")
        self.shape = (2, height, width)
        self.slot_bytes = 64 + (2 * width * height + 63) // 64 * 64
        self.written = 0
        if os.path.exists(self.path):
            os.unlink(self.path)  # readers of an earlier writer notice
        descriptor = os.open(self.path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o600)
        os.ftruncate(descriptor, 64 + SLOTS * self.slot_bytes)
        self.memory = mmap.mmap(descriptor, 0)
        os.close(descriptor)
        self.memory[:24] = struct.pack("<8sIIII", b"SGPAIR01", width, height, SLOTS, 0)

    def write(self, left: np.ndarray, right: np.ndarray, captured_ns: int = 0) -> None:
        """`captured_ns`: time.monotonic_ns() at the exposure; 0: when the pair is read."""
        self.written += 1
        at = 64 + (self.written - 1) % SLOTS * self.slot_bytes
        self.memory[at:at + 8] = struct.pack("<Q", self.written)
        images = np.frombuffer(self.memory, np.uint8, 2 * left.size, at + 64).reshape(self.shape)
        images[0], images[1] = left, right
        self.memory[at + 8:at + 24] = struct.pack("<Qq", self.written, captured_ns)
        self.memory[24:32] = struct.pack("<Q", self.written)

    def remove(self) -> None:
        os.unlink(self.path)


def main() -> None:
    name, width, height, seconds = sys.argv[1], *map(int, sys.argv[2:5])
    noise = np.random.default_rng(1).integers(0, 256, (height, width + 8), np.uint8)
    pairs = SharedPairs(name, width, height)
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pairs.write(noise[:, :width], noise[:, 8:], time.monotonic_ns())
        time.sleep(1 / 30)
    pairs.remove()


if __name__ == "__main__":
    main()
