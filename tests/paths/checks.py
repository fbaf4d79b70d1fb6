# SPDX-License-Identifier: Apache-2.0
"""Checks of the tests of paths. A finding that does not hold is a failure."""

from __future__ import annotations

import struct
from typing import Iterator, NamedTuple

import numpy as np

from runs import Lab, Recorded, Result
from sources import SOURCES
from tables import BOUNDS, DEVICES, PRESETS, SCENES, Row

FREE, OCCUPIED = 0.45, 0.55
MOVING_FROM = 0.5
"""Probability of moving mass from which a cell counts as moving."""
STAGES = ("match", "ground", "project", "filter", "track")
"""Of timing_ms: stages that each preset has."""
UNUSABLE = {"few_matches", "road_unknown"}
"""Statuses of frames that have no observation."""
GRIDS = ("observed", "occupancy")


class Finding(NamedTuple):
    row: Row
    check: str
    holds: bool
    expected: str
    found: object

    def __str__(self) -> str:
        return f"{self.row}: {self.check}: expected {self.expected}, found {self.found}"


def parent_of(row: Row) -> Row:
    """Returns the run that a row is compared with: of the source with the same results, else the same on the CPU."""
    source = SOURCES[row.source]
    if source.command == "live":  # on the same device, as messages are compared to the bit
        return row._replace(source=source.parent)
    if source.relation == "same" or row.device == "cpu":
        row = row._replace(source=source.parent)
    return row._replace(device="cpu")


def check_row(lab: Lab, row: Row) -> Iterator[Finding]:
    relation = SOURCES[row.source].relation
    # without extrinsics, ground that is not level has no plane that two unequal inputs need to agree on
    is_certain = row.extrinsics == "given" or SCENES[row.scene].is_level
    run = lab.run(row)
    if isinstance(run, Result):
        yield from traces(row, run, is_certain)
    if row.device != "cpu" or relation == "same":
        yield from same(row, run, lab.run(parent_of(row), DEVICES[row.device].short))
    elif relation == "rounded" and is_certain:
        yield from rounded(row, run, lab.run(parent_of(row)))
    elif relation and is_certain:
        yield from scores(lab, row)


def within(row: Row, check: str, found: "float | None", least: float = -np.inf, most: float = np.inf) -> Finding:
    """Holds if the figure lies within an interval, both ends included; a missing one does not."""
    expected = f">= {least:g}" if most == np.inf else f"<= {most:g}" if least == -np.inf else f"{least:g} to {most:g}"
    return Finding(row, check, found is not None and least <= found <= most, expected, found)


def traces(row: Row, run: Result, is_certain: bool) -> Iterator[Finding]:
    """No stage is skipped: each leaves times, layers or obstacles."""
    scene, preset = SCENES[row.scene], PRESETS[row.preset]
    for stage in (*STAGES, "flow") if preset.flow else STAGES:
        yield within(row, f"timing_ms.{stage}", min(f["timing_ms"][stage] for f in run.frames), 1e-9)
    if not is_certain:
        return
    usable = [i for i, frame in enumerate(run.frames) if not UNUSABLE.intersection(frame["status"])]
    grids = [run.grids(i) for i in usable]
    for i, grid in zip(usable, grids):
        yield within(row, f"observed cells of frame {i}", int(np.isfinite(grid["age_s"]).sum()), 1)
        if preset.terrain:
            yield within(row, f"cells with elevation of frame {i}", int(np.isfinite(grid["elevation_m"]).sum()), 1)
    if DEVICES[row.device].short:
        return
    if preset.terrain and scene.has_drop:
        drops = [any(thing["kind"] == "drop" for thing in f["obstacles"]) for f in run.frames]
        yield within(row, "share of frames with a drop", float(np.mean(drops)), BOUNDS.frames_with_drop)
    if row.preset in scene.moving_for and row.poses != "none":
        yield within(row, "moving cells of the last frame", int((grids[-1]["moving"] > MOVING_FROM).sum()), 1)


def _difference(name: str, ours: np.ndarray, theirs: np.ndarray, device: str) -> str:
    if (ours.dtype, ours.shape) != (theirs.dtype, theirs.shape):
        return f"{name} is {ours.dtype}{ours.shape}, not {theirs.dtype}{theirs.shape}"
    tolerance = DEVICES[device].tolerances.get(name, 0.0)
    if ours.tobytes() == theirs.tobytes() or tolerance and np.allclose(ours, theirs, 0, tolerance, equal_nan=True):
        return ""
    bytes_of = [np.frombuffer(array.tobytes(), np.uint8).reshape(array.size, -1) for array in (ours, theirs)]
    return f"{int((bytes_of[0] != bytes_of[1]).any(axis=1).sum())} of {ours.size} values of {name} differ"


def _grids_difference(run: Result, parent: Result, device: str) -> str:
    for i, frame in enumerate(run.frames):
        ours, theirs = run.grids(i), parent.grids(i)
        if ours.keys() != theirs.keys():
            return f"frame {i}: only one has {', '.join(sorted(ours.keys() ^ theirs.keys()))}"
        for name, array in ours.items():
            if found := _difference(name, array, theirs[name], device):
                return f"frame {i}: {found}"
    return "equal"


def _texts(messages: "list[bytes]") -> "list[str]":
    """The text of the DiagnosticStatus in each message of the topic status: the first warning, else the status."""
    texts = []
    for data in messages:
        at = 0
        for skipped in (0, 5, 0):  # before frame_id; number of statuses and level, before name; before text
            at = -(-(at + skipped) // 4) * 4
            size, = struct.unpack("<I", data[at:at + 4])
            text = data[at + 4:at + 3 + size].decode()
            at += 4 + size
            at += -at % 4
        texts.append(text)
    return texts


def _first_difference(ours: list, theirs: list) -> str:
    """Compares two lists with an entry for each frame."""
    if len(ours) != len(theirs):
        return f"{len(ours)} frames instead of {len(theirs)}"
    differ = [i for i, (a, b) in enumerate(zip(ours, theirs)) if a != b]
    if not differ:
        return "equal"
    i = differ[0]
    values = "" if isinstance(ours[i], bytes) else f": {ours[i]} instead of {theirs[i]}"
    return f"{len(differ)} of {len(ours)} frames differ, the first is {i}{values}"


def equal(row: Row, what: str, ours: list, theirs: list) -> Finding:
    found = _first_difference(ours, theirs)
    return Finding(row, what, found == "equal", "equal", found)


def _kinds(run: Result) -> list:
    return [sorted((thing["kind"], thing["moving"]) for thing in frame["obstacles"]) for frame in run.frames]


def same(row: Row, run: "Result | Recorded", parent: Result) -> Iterator[Finding]:
    """Checks that grids and statuses of equal inputs are equal to the bit."""
    if isinstance(run, Recorded):
        for topic, messages in parent.recorded().messages.items():
            found = run.messages.get(topic, [])
            if topic.endswith("/status"):
                yield equal(row, "statuses", _texts(found), _texts(messages))
            else:
                yield equal(row, f"messages of {topic}", found, messages)
        return
    yield equal(row, "statuses", run.statuses(), parent.statuses())
    yield equal(row, "obstacles", _kinds(run), _kinds(parent))
    if len(run.frames) == len(parent.frames):
        found = _grids_difference(run, parent, row.device)
        yield Finding(row, "grids", found == "equal", "equal", found)


def rounded(row: Row, run: Result, parent: Result) -> Iterator[Finding]:
    """Checks that few cells change between free and occupied where inputs differ by rounding."""
    yield equal(row, "statuses", run.statuses(), parent.statuses())
    for grid in GRIDS:
        flips = cells = 0
        for i in range(len(parent.frames)):
            ours, theirs = run.grids(i)[grid], parent.grids(i)[grid]
            flips += int((((ours < FREE) & (theirs > OCCUPIED)) | ((ours > OCCUPIED) & (theirs < FREE))).sum())
            cells += int(((theirs < FREE) | (theirs > OCCUPIED)).sum())
        yield within(row, f"share of cells of {grid} that flip", flips / max(cells, 1), most=BOUNDS.flips)


def _figures(series: dict) -> "dict[str, float]":
    """Returns the figures of a grid to compare; shares over both ranges."""
    found = {}
    band = series["bands"].get("3-20", {})
    if band.get("balanced_log_loss", {}).get("value") is not None:
        found["log_loss"] = band["balanced_log_loss"]["value"]
    for share, of in (("edges_found", "edges"), ("deadly_share", "deadly")):
        ranges = [one for one in series.get("terrain", {}).get("ranges", {}).values() if one.get(of)]
        if ranges:
            values = [one[share]["value"] if isinstance(one[share], dict) else one[share] for one in ranges]
            found[share] = sum(v * one[of] for v, one in zip(values, ranges)) / sum(one[of] for one in ranges)
    for name in ("velocity_error_mps", "cell_velocity_error_mps"):
        value = series.get("motion", {}).get(name)
        value = value.get("value") if isinstance(value, dict) else value
        if value is not None:
            found[name] = value
    return found


def scores(lab: Lab, row: Row) -> Iterator[Finding]:
    """Checks that external disparities are as good as the own path, and true ones as good as the bounds."""
    scene, preset = SCENES[row.scene], PRESETS[row.preset]
    parent = parent_of(row)
    run, own = lab.run(row), lab.run(parent)
    is_true = SOURCES[row.source].relation == "true"
    # noise decides about a slope at the limit of the pitch gate
    others = sum(ours != theirs for ours, theirs in zip(run.statuses(), own.statuses()))
    yield within(row, "frames with another status", others, most=BOUNDS.true_statuses if is_true else 0)
    if row.preset not in scene.scored:
        return
    # a filter that takes a moving vehicle for a static one has no truth
    for grid in GRIDS if row.poses != "none" else GRIDS[:1]:
        ours, theirs = (_figures(lab.scores(one)[grid]) for one in (row, parent))
        change = {name: ours[name] - theirs[name] for name in ours if name in theirs}
        if "log_loss" in change:
            most = preset.log_loss_of_true if is_true else preset.log_loss
            yield within(row, f"change of the log-loss of {grid}", change["log_loss"], most=most)
        if preset.terrain and "edges_found" in ours:
            least = BOUNDS.true_edges if is_true else theirs["edges_found"] - BOUNDS.edges
            yield within(row, f"edges found in {grid}", ours["edges_found"], least)
        if preset.terrain and "deadly_share" in ours:
            most = BOUNDS.true_deadly if is_true else theirs["deadly_share"] + BOUNDS.deadly
            yield within(row, f"share of deadly cells of {grid} that are free", ours["deadly_share"], most=most)
    for name in ("velocity_error_mps", "cell_velocity_error_mps"):
        if preset.flow and row.preset in scene.moving_for and name in theirs and row.poses != "none":
            most = scene.true_velocity_mps if is_true else theirs[name] + BOUNDS.velocity_mps
            yield within(row, name, ours.get(name), most=most)
