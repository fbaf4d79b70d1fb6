# SPDX-License-Identifier: Apache-2.0
"""Files that the tests of paths write and read: PNG, bags of ROS 2 (SQLite, CDR) and recordings (MCAP)."""

from __future__ import annotations

import ctypes
import ctypes.util
import math
import sqlite3
import struct
import zlib
from pathlib import Path

import numpy as np

PNG = b"\x89PNG\r\n\x1a\n"
MCAP = b"\x89MCAP0\r\n"
MCAP_CHANNEL, MCAP_MESSAGE, MCAP_CHUNK = 4, 5, 6
STAMP_END = 12  # a message begins with 4 bytes of encapsulation and the 8 of its header's stamp


def read_png(path: Path) -> np.ndarray:
    """A grey image of 8 bits whose rows have the filters none, sub or up, as those of OpenCV's encoder."""
    data, at, packed = path.read_bytes(), len(PNG), b""
    width, height = struct.unpack(">II", data[at + 8:at + 16])
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            packed += data[at + 8:at + 8 + length]
        at += 12 + length
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, width + 1)
    image, above = np.empty((height, width), np.uint8), np.zeros(width, np.uint8)
    for row, (kind, line) in enumerate(zip(rows[:, 0], rows[:, 1:])):
        if kind > 2:
            raise ValueError(f"{path}: filter {kind} of row {row} (allowed 0 to 2).")
        above = image[row] = (line, np.cumsum(line, dtype=np.uint8), line + above)[kind]
    return image


def write_png(path: Path, image: np.ndarray) -> None:
    """A grey image of 8 or 16 bits."""
    height, width = image.shape
    big_endian = image.astype(image.dtype.newbyteorder(">"))
    rows = np.zeros((height, 1 + width * image.itemsize), np.uint8)
    rows[:, 1:] = np.frombuffer(big_endian.tobytes(), np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * image.itemsize, 0, 0, 0, 0)
    with path.open("wb") as file:
        file.write(PNG)
        for kind, data in ((b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 1)), (b"IEND", b"")):
            file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


class Cdr:
    """Encodes a message: little endian, each number aligned to its size."""

    def __init__(self, stamp_ns: int):
        self.data = bytearray(b"\0\1\0\0")
        self.put("i", stamp_ns // 10**9).put("I", stamp_ns % 10**9).text("camera")

    def put(self, kind: str, *numbers: float) -> "Cdr":
        for number in numbers:
            self.data += b"\0" * (-(len(self.data) - 4) % struct.calcsize(kind)) + struct.pack("<" + kind, number)
        return self

    def text(self, text: str) -> "Cdr":
        self.put("I", len(text) + 1)
        self.data += text.encode() + b"\0"
        return self

    def bytes(self, data: bytes) -> "Cdr":
        self.put("I", len(data))
        self.data += data
        return self


def image_message(stamp_ns: int, image: np.ndarray) -> Cdr:
    encoding = {np.dtype("u1"): "mono8", np.dtype("u2"): "16UC1", np.dtype("f4"): "32FC1"}[image.dtype]
    height, width = image.shape
    message = Cdr(stamp_ns).put("I", height, width).text(encoding).put("B", 0).put("I", width * image.itemsize)
    return message.bytes(image.tobytes())


def camera_info_message(stamp_ns: int, rig: dict, baseline_m: float) -> Cdr:
    focal, u, v = rig["focal_px"], rig["cx_px"], rig["cy_px"]
    message = Cdr(stamp_ns).put("I", rig["height_px"], rig["width_px"]).text("plumb_bob").put("I", 5)
    message.put("d", *[0] * 5, focal, 0, u, 0, focal, v, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1)
    message.put("d", focal, 0, u, -focal * baseline_m, 0, focal, v, 0, 0, 0, 1, 0)
    return message.put("I", 0, 0, 0, 0, 0, 0).put("B", 0)


def quaternion_of(yaw_rad: float) -> "tuple[float, float]":
    """z and w whose heading, as the tool computes it, equals `yaw_rad` to the bit."""
    for i in range(20000):
        scale = 1 + i * 1e-6  # unit quaternions need not be exact
        z = scale * math.sin(yaw_rad / 2) * (1 + (i % 9 - 4) * 2**-52)
        w = scale * math.cos(yaw_rad / 2) * (1 + (i // 9 % 9 - 4) * 2**-52)
        length = math.sqrt(z * z + w * w)
        unit_z, unit_w = z / length, w / length
        if math.atan2(2 * (unit_w * unit_z), 1 - 2 * (unit_z * unit_z)) == yaw_rad:
            return z, w
    raise ValueError(f"no quaternion gives exactly {yaw_rad!r}")


def odometry_message(stamp_ns: int, x_m: float, y_m: float, yaw_rad: float) -> Cdr:
    return Cdr(stamp_ns).text("base_link").put("d", x_m, y_m, 0, 0, 0, *quaternion_of(yaw_rad), *[0] * (36 + 6 + 36))


def write_bag(path: Path, messages: "list[tuple[str, str, int, Cdr]]") -> None:
    """A .db3 of rosbag2; a message is topic, type, stamp and content."""
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT, "
                     "offered_qos_profiles TEXT)")
    database.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    topics: dict = {}
    for topic, kind, stamp_ns, message in messages:
        if topic not in topics:
            topics[topic] = len(topics) + 1
            database.execute("INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')", (topics[topic], topic, kind))
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)",
                         (topics[topic], stamp_ns, bytes(message.data)))
    database.commit()
    database.close()


def _unpacked(packed: bytes, size: int) -> bytes:
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    data = ctypes.create_string_buffer(size)
    if library.ZSTD_decompress(data, ctypes.c_size_t(size), packed, ctypes.c_size_t(len(packed))) != size:
        raise ValueError("a chunk of the recording cannot be unpacked")
    return data.raw


def _records(data: bytes) -> "list[tuple[int, bytes]]":
    found, at = [], 0
    while at + 9 <= len(data):
        kind, size = struct.unpack("<BQ", data[at:at + 9])
        if at + 9 + size > len(data):  # the magic at the end of the file
            break
        found.append((kind, data[at + 9:at + 9 + size]))
        at += 9 + size
    return found


def read_recording(path: Path) -> "dict[str, list[bytes]]":
    """By topic, the messages without their stamps."""
    topics: dict = {}
    messages: dict = {}
    for kind, record in _records(path.read_bytes()[len(MCAP):]):
        parts = [(kind, record)]
        if kind == MCAP_CHUNK:
            size, name_size = struct.unpack("<16xQ4xI", record[:32])
            packed = record[32 + name_size + 8:]
            parts = _records(_unpacked(packed, size) if name_size else packed)
        for part, content in parts:
            if part == MCAP_CHANNEL:
                number, size = struct.unpack("<H2xI", content[:8])
                topics[number] = content[8:8 + size].decode()
            if part == MCAP_MESSAGE:
                number, = struct.unpack("<H", content[:2])
                messages.setdefault(topics[number], []).append(content[22 + STAMP_END:])
    return messages
