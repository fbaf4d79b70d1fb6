# SPDX-License-Identifier: Apache-2.0
"""python -m stereogrid DRIVE: shows a drive, frame by frame."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import stereogrid as sg


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m stereogrid", description="Shows the grids of a drive.")
    parser.add_argument("drive", help="what stereogrid run takes as INPUT, such as a folder or scene:street")
    parser.add_argument("--preset", default="default", choices=[*sg.preset_names(), "auto"])
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a parameter; may be repeated")
    parser.add_argument("--frames", default="", metavar="FIRST:LAST")
    parser.add_argument("--save", type=Path, metavar="DIR", help="write a figure per frame instead of showing it")
    parser.add_argument("--no-plot", action="store_true", help="print a line per frame only")
    return parser.parse_args()


def line(result: sg.FrameResult) -> str:
    flags = " ".join(status.name for status in result.status)
    moving = sum(obstacle.moving for obstacle in result.obstacles)
    return (
        f"{result.name}: {len(result.obstacles)} obstacles, {moving} moving, {result.timing_ms['total']:.1f} ms {flags}"
    )


def show(frame: sg.Frame, result: sg.FrameResult, folder: Path | None) -> None:
    import matplotlib

    if folder is not None:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from stereogrid import plot

    plt.close("all")
    figure = plot.frame(frame, result)
    if folder is None:
        plt.pause(0.001)
    else:
        folder.mkdir(parents=True, exist_ok=True)
        figure.savefig(folder / f"{result.name}.png", dpi=80)


def main() -> int:
    options = arguments()
    try:
        recording = sg.open(options.drive, frames=options.frames)
        config = sg.preset(sg.preset_for(recording) if options.preset == "auto" else options.preset)
        for setting in options.set:
            key, _, value = setting.partition("=")
            config.set(key, value)
        pipeline = sg.Pipeline(config, recording.rigs)
        for frame in recording:
            result = pipeline.process(frame)
            print(line(result).rstrip())
            if not options.no_plot:
                show(frame, result, options.save)
    except sg.Error as error:
        print(f"stereogrid: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"stereogrid: {error}. Install stereogrid[plot], or give --no-plot.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
