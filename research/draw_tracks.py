#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Draws the paths of a run's obstacles in the world, seen from above: draw_tracks.py RUN_DIR TRACKS.svg

Reads RUN_DIR/frames.jsonl (docs/format.md). Confirmed obstacles that were seen in at least --frames frames; the vehicle's
own path is grey. Dynamic obstacles have the colour of their speed, their id and their median speed; static ones are
grey dots.
"""
import argparse
import json
import math
import os
import statistics
import sys

PX_PER_M = 12
MARGIN_M = 3
LABEL_PX = 150
MOVING_MPS = 1.0
FAST_MPS = 15.0


def to_world(pose, x, y):
    c, s = math.cos(pose["yaw_rad"]), math.sin(pose["yaw_rad"])
    return pose["x_m"] + c * x - s * y, pose["y_m"] + s * x + c * y


def read_run(path):
    way, tracks = [], {}
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            frame = json.loads(line)
            pose = frame["pose"]
            way.append((pose["x_m"], pose["y_m"]))
            for obstacle in frame["obstacles"]:
                if not obstacle["confirmed"] or obstacle["coasting"]:
                    continue
                place = to_world(pose, obstacle["x_m"], obstacle["y_m"])
                speed = math.hypot(obstacle["vx_mps"], obstacle["vy_mps"])
                tracks.setdefault(obstacle["id"], []).append((place, speed, obstacle["moving"]))
    return way, tracks


def colour(speed):
    hue = 220 * (1 - min(speed / FAST_MPS, 1))
    return f"hsl({hue:.0f},85%,42%)"


class Drawing:
    """World x to the right, y upwards."""

    def __init__(self, points):
        self.x_min = min(x for x, _ in points) - MARGIN_M
        self.y_max = max(y for _, y in points) + MARGIN_M
        self.width = (max(x for x, _ in points) + MARGIN_M - self.x_min) * PX_PER_M + LABEL_PX
        self.height = (self.y_max - min(y for _, y in points) + MARGIN_M) * PX_PER_M
        self.shapes = []

    def at(self, point):
        return (point[0] - self.x_min) * PX_PER_M, (self.y_max - point[1]) * PX_PER_M

    def line(self, points, stroke, width):
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in map(self.at, points))
        self.shapes.append(f'<polyline points="{text}" fill="none" stroke="{stroke}" stroke-width="{width}"/>')

    def dot(self, point, fill, radius):
        x, y = self.at(point)
        self.shapes.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius}" fill="{fill}"/>')

    def label(self, point, text, fill):
        x, y = self.at(point)
        self.shapes.append(f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="{fill}" font-size="13">{text}</text>')

    def scale(self):
        y = self.height - 12
        self.shapes.append(f'<path d="M12 {y - 4} v4 h{10 * PX_PER_M} v-4" fill="none" stroke="black"/>'
                           f'<text x="{18 + 10 * PX_PER_M}" y="{y}" font-size="13">10 m</text>')

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width:.0f}" height="{self.height:.0f}" '
                f'font-family="sans-serif"><rect width="100%" height="100%" fill="white"/>\n' + "\n".join(self.shapes) +
                "\n</svg>\n")


def draw(way, tracks, frames_min):
    kept = {number: sightings for number, sightings in tracks.items() if len(sightings) >= frames_min}
    drawing = Drawing(way + [place for sightings in kept.values() for place, _, _ in sightings])
    drawing.line(way, "#bbb", 6)
    drawing.dot(way[0], "#888", 7)
    for number, sightings in sorted(kept.items()):
        places = [place for place, _, _ in sightings]
        speed = statistics.median(speed for _, speed, _ in sightings)
        moves = speed > MOVING_MPS and 2 * sum(moving for _, _, moving in sightings) > len(sightings)
        if not moves:
            drawing.dot(places[-1], "#777", 3)
            continue
        drawing.line(places, colour(speed), 3)
        drawing.dot(places[-1], colour(speed), 5)
        drawing.label(places[-1], f"{number}: {speed:.1f} m/s, {len(sightings)} frames", colour(speed))
    drawing.scale()
    return drawing.svg()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("svg")
    parser.add_argument("--frames", type=int, default=8, help="fewest sightings of an obstacle (default: 8)")
    arguments = parser.parse_args()
    path = os.path.join(arguments.run, "frames.jsonl")
    if not os.path.exists(path):
        sys.exit(f"{path}: not there. Give the folder that `stereogrid run --out` has left.")
    way, tracks = read_run(path)
    if not way:
        sys.exit(f"{path}: no frames.")
    with open(arguments.svg, "w", encoding="utf-8") as out:
        out.write(draw(way, tracks, arguments.frames))


if __name__ == "__main__":
    main()
