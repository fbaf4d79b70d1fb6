# SPDX-License-Identifier: Apache-2.0
"""Runs of the tests of paths: each drive, input and run is made once, by the first check that needs it."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import threading
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Callable

import numpy as np

import formats
from sources import SOURCES, Drive, Made, cut_drive, read_drive
from tables import BASELINE_M, DEVICES, PRESETS, ROBOT_BASELINE_M, SCENES, SHORT, Row

RECORDED = ("grid_map", "status")
"""Topics without other stamps than that of the header."""
LIVE_TRIES = 4
SLOWEST = 0.01
"""Lower limit of --speed."""


class RunFailed(Exception):
    """An error of the tool or the package; the text has the command and the last line of its output."""


class Result:
    """The files of a run."""

    def __init__(self, folder: Path):
        self.folder = folder
        lines = (folder / "frames.jsonl").read_text().splitlines()
        self.frames = [json.loads(line) for line in lines]

    def grids(self, place: int) -> "dict[str, np.ndarray]":
        with np.load(self.folder / "grids" / f"{self.frames[place]['name']}.npz") as arrays:
            return dict(arrays)

    def statuses(self) -> "list[list[str]]":
        return [frame["status"] for frame in self.frames]

    def recorded(self) -> "Recorded":
        return Recorded(self.folder.with_suffix(".mcap"))


class Recorded:
    """The messages of a run, without their stamps; a live run has these alone."""

    def __init__(self, file: Path):
        self.messages = formats.read_recording(file)


class Lab:
    def __init__(self, tool: str, work: Path, emulator: str = "", python: str = ""):
        self.tool, self.work, self.python = tool, work, python
        self.environment = dict(os.environ)
        if emulator:
            self.environment["STEREOGRID_CUDA_LIBRARY"] = emulator
        self._made: "dict[tuple, Future]" = {}
        self._lock = threading.Lock()

    def once(self, key: tuple, make: "Callable[[Path], Any]") -> Any:
        """Returns what `make` has returned for the key; another thread that makes it is waited for."""
        with self._lock:
            future = self._made.get(key)
            is_new = future is None
            if future is None:
                future = self._made[key] = Future()
                folder = self.work / re.sub(r"[^a-z0-9_.]+", "-", "-".join(map(str, key)).lower())
        if is_new:
            try:
                future.set_result(make(folder))
            except BaseException as error:  # pylint: disable=broad-except
                future.set_exception(error)
        return future.result()

    def call(self, arguments: "list[str]", program: str = "") -> str:
        command = [*(shlex.split(program) if program else [self.tool]), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=self.environment, timeout=600)
        if done.returncode:
            last_line = (done.stderr.strip() or "no message").splitlines()[-1]
            raise RunFailed(f"exit code {done.returncode} of {shlex.join(command)}: {last_line}")
        return done.stderr

    def drive(self, row: Row) -> Drive:
        scene, is_short = SCENES[row.scene], DEVICES[row.device].short
        size, frames = (SHORT.size, SHORT.frames) if is_short else (scene.size, scene.frames)
        layout = scene.robot if row.preset == "robot" and scene.robot else scene.car
        baseline_m = ROBOT_BASELINE_M if "camera=robot" in layout else BASELINE_M
        text = (f"scene:{layout}&width={size[0]}&height={size[1]}&frames={scene.first + frames}"
                f"&baseline={baseline_m:g}")

        def simulate(folder: Path) -> Path:
            self.call(["-q", "simulate", text, "--out", folder])
            cut_drive(folder, scene.first)
            return folder

        def mount(folder: Path) -> Drive:
            source = self.once(("scene", text), simulate)
            folder.mkdir()
            for name in ("left", "right", "truth", "poses.csv"):
                (folder / name).symlink_to(source / name)
            lines = (source / "calibration.yaml").read_text().splitlines(keepends=True)
            is_kept = [row.extrinsics == "given" or not line.startswith("mount") for line in lines]
            (folder / "calibration.yaml").write_text("".join(line for line, kept in zip(lines, is_kept) if kept))
            return read_drive(folder, text, scene.first)

        return self.once(("drive", text, row.extrinsics), mount)

    def made(self, row: Row) -> Made:
        drive = self.drive(row)
        is_short = DEVICES[row.device].short

        def own_disparities() -> "dict[str, np.ndarray]":
            # without extrinsics, a slope tilts the images that the disparities belong to
            run = self.run(row._replace(source="folder", device="cpu", extrinsics="given"), is_short)
            found = {}
            for frame in run.frames:
                with np.load(run.folder / "stages" / f"{frame['name']}.npz") as stages:
                    found[frame["name"]] = stages["obstacle_disparity"] + stages["road_disparity"]
            return found

        def make(folder: Path) -> Made:
            folder.mkdir()
            return SOURCES[row.source].make(drive, folder, own_disparities)

        return self.once(("input", row.scene, row.source, row.preset, row.extrinsics, row.poses, is_short), make)

    def run(self, row: Row, is_short: "bool | None" = None) -> Result:
        """`is_short`: also on a device that could take the whole scene."""
        if is_short is None:
            is_short = DEVICES[row.device].short
        commands = {"run": self._run, "live": self._live, "python": self._python}
        of_inputs = row._replace(device=next(name for name, device in DEVICES.items() if device.short == is_short))
        parameters = PRESETS[row.preset].short if is_short else ()

        def make(folder: Path) -> Any:
            return commands[SOURCES[row.source].command](row, self.made(of_inputs), parameters, folder)

        return self.once(("run", *row, is_short), make)

    @staticmethod
    def _options(row: Row, made: Made, parameters: "tuple[str, ...]") -> "list[str]":
        options = [*made.arguments, "--poses", row.poses, "--preset", row.preset, "--device", row.device, "--threads", "1"]
        return options + [word for parameter in parameters for word in ("--set", parameter)]

    def _run(self, row: Row, made: Made, parameters: "tuple[str, ...]", folder: Path) -> Result:
        more = ["--mcap", folder.with_suffix(".mcap"), "--mcap-topics", ",".join(RECORDED)]
        more += ["--save-stages"] if row.source == "folder" else []
        self.call(["-q", "run", *self._options(row, made, parameters), *more, "--out", folder])
        return Result(folder)

    def _live(self, row: Row, made: Made, parameters: "tuple[str, ...]", folder: Path) -> Recorded:
        """Runs again, and slower, where frames were dropped."""
        speed = DEVICES[row.device].live_speed
        wanted = (SHORT if DEVICES[row.device].short else SCENES[row.scene]).frames
        for _ in range(LIVE_TRIES):
            recording = folder.with_suffix(".mcap")
            recording.unlink(missing_ok=True)
            self.call(["-q", "live", *self._options(row, made, parameters), "--speed", f"{speed:g}", "--listen",
                       "127.0.0.1:0", "--mcap", recording, "--mcap-topics", ",".join(RECORDED)])
            found = Recorded(recording)
            if len(found.messages.get("/stereo_grid/grid_map", [])) == wanted:
                break
            speed = max(speed / 3, SLOWEST)
        return found

    def _python(self, row: Row, made: Made, parameters: "tuple[str, ...]", folder: Path) -> Result:
        folder.mkdir()
        options = dict(zip(made.arguments[1::2], made.arguments[2::2]), **{"--poses": row.poses})
        job = {"path": made.arguments[0], "open": {key[2:]: value for key, value in options.items()},
               "arrays": made.arrays, "preset": row.preset, "device": row.device, "out": str(folder),
               "set": [parameter.split("=") for parameter in parameters]}
        self.call([str(Path(__file__).with_name("python_run.py")), json.dumps(job)], self.python)
        return Result(folder)

    def scores(self, row: Row) -> dict:
        """Returns the series of `stereogrid evaluate`."""

        def evaluate(file: Path) -> dict:
            self.call(["-q", "evaluate", self.run(row).folder, self.drive(row).folder, "--json", file])
            return json.loads(file.read_text())["series"]

        return self.once(("scores", *row), evaluate)
