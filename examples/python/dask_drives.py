#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Many drives on Dask workers: dask_drives.py OUT DRIVE... [--workers N | --scheduler ADDRESS]

Each drive becomes one file OUT/NAME.npz, which appears whole or not at all. A drive whose worker dies is computed again
by another one; a drive that has its file is skipped.
"""

import argparse
import os
from pathlib import Path

import numpy as np
from dask.distributed import Client, LocalCluster, as_completed

import stereogrid as sg


def process(drive: str, out: str) -> tuple[str, int]:
    """Writes the last grid of a drive and returns its number of frames."""
    target = Path(out) / (Path(drive.replace("scene:", "").replace("?", "_")).name + ".npz")
    if target.exists():
        with np.load(target) as arrays:
            return drive, int(arrays["frames"])
    recording = sg.open(drive)
    pipeline = sg.Pipeline(sg.preset("default"), recording.rig, threads=1, stages=False)
    count = 0
    for frame in recording:
        result = pipeline.process(frame)
        count += 1
    part = target.with_name(f".{target.name}.{os.getpid()}.npz")
    np.savez_compressed(part, occupancy=result.occupancy, velocity=result.velocity, frames=count)
    part.rename(target)
    return drive, count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    parser.add_argument("drives", nargs="+")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--scheduler", help="address of a running scheduler, instead of local workers")
    options = parser.parse_args()
    Path(options.out).mkdir(parents=True, exist_ok=True)
    cluster = options.scheduler or LocalCluster(n_workers=options.workers, threads_per_worker=1, dashboard_address=None)
    with Client(cluster) as client:
        futures = client.map(process, options.drives, out=options.out, retries=3)
        for future in as_completed(futures):
            drive, count = future.result()
            print(f"{drive}: {count} frames", flush=True)


if __name__ == "__main__":
    main()
