# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Which rows of the product a turn runs: always the same few that contain each pair of entries, and a part that moves on
with the turn."""

from __future__ import annotations

import random
from itertools import combinations, product

from sources import SOURCES
from tables import DEVICES, EXTRINSICS, POSES, PRESETS, SCENES, Row


def all_rows(devices: "set[str]", has_python: bool) -> "list[Row]":
    """The product, without what does not exist; in an order that mixes the entries of all tables."""
    rows = [Row(*entries) for entries in product(SCENES, SOURCES, DEVICES, PRESETS, EXTRINSICS, POSES)]
    rows = [row for row in rows if row.device in devices and row.extrinsics in SOURCES[row.source].extrinsics and
            (has_python or SOURCES[row.source].command != "python") and
            not (row.source == "folder" and row.device == "cpu") and
            # --frames keeps the world of the scene, a folder without its first frames begins a new one
            not (row.source == "scene" and SCENES[row.scene].first and row.poses == "file")]
    random.Random(1).shuffle(rows)
    return rows


def pairs_of(row: Row) -> "set[tuple]":
    return set(combinations(enumerate(row), 2))


def covering(rows: "list[Row]") -> "list[Row]":
    """Rows that contain each pair of entries of two tables that there is; the next one is that with most new pairs. Most
    are of the CPU, where a row costs least and has most checks."""
    pairs = {row: pairs_of(row) for row in rows}
    chosen: "list[Row]" = []
    covered: "set[tuple]" = set()
    for candidates in ([row for row in rows if row.device == "cpu"], rows):
        missing = set().union(*(pairs[row] for row in candidates)) - covered
        while missing:
            best = max(candidates, key=lambda row: len(pairs[row] & missing))
            missing -= pairs[best]
            covered |= pairs[best]
            chosen.append(best)
    return chosen


def selected(rows: "list[Row]", turn: int, part: int) -> "list[Row]":
    """The covering rows, and `part` of the others, the next ones in each turn."""
    fixed = covering(rows)
    others = [row for row in rows if row not in set(fixed)]
    begin = turn * part % max(len(others), 1)
    return fixed + (others + others)[begin:begin + min(part, len(others))]
