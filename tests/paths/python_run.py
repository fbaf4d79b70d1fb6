# SPDX-License-Identifier: Apache-2.0
"""A run by the Python package, with arrays as input; the argument is a job of runs.py. Writes grids and frames.jsonl as
`stereogrid run` does, of the latter only what the checks read."""

import json
import sys
from pathlib import Path

import numpy as np
import stereogrid as sg


def main() -> None:
    job = json.loads(sys.argv[1])
    config = sg.preset(job["preset"])
    for key, value in job["set"]:
        config.set(key, value)
    recording = sg.open(job["path"], **job["open"])
    pipeline = sg.Pipeline(config, recording.rig, device=job["device"], threads=1)
    out = Path(job["out"])
    (out / "grids").mkdir()
    lines = []
    for frame in recording:
        arrays = {key: np.load(Path(folder) / f"{frame.name}.npy") for key, folder in job["arrays"].items()}
        arrays = arrays or {"right": np.array(frame.right)}
        result = pipeline.process(np.array(frame.left), stamp_ns=frame.stamp_ns, pose=frame.pose, **arrays)
        result.save(out / "grids" / f"{frame.name}.npz")
        obstacles = [{"kind": thing.kind, "moving": thing.moving} for thing in result.obstacles]
        lines.append(json.dumps({"name": frame.name, "status": [status.name for status in result.status],
                                 "timing_ms": result.timing_ms, "obstacles": obstacles}))
    (out / "frames.jsonl").write_text("\n".join(lines) + "\n")


main()
