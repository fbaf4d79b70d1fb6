#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the generated parts of README.md: snippets from example files and the table of measured figures.

readme.py            writes README.md
readme.py --check    exit status 1 if README.md differs from the sources
readme.py --figures  renders the figures in docs/pictures; needs the release build (with tests) and ffmpeg
readme.py --screens  renders the viewer's page for docs/ros2.md; needs Chromium, too
"""
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import results  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
# text of the first column, measurement, title of its table ("": any), first cells of the rows ("": any), columns with their units; of several rows the
# least and the greatest value, of counts the sum
MEASURED = (
    ("Occupancy against lidar, single frames, ray weights fitted on other inputs: KITTI odometry 04", "lidar-left-out", "", ("kitti_odo04",),
     {"AUC": "AUC {}", "log-loss": "log-loss {}"}),
    ("… KITTI raw 0009", "lidar-left-out", "", ("kitti_raw0009",), {"AUC": "AUC {}", "log-loss": "log-loss {}"}),
    ("… fitted on these, too, filtered: KITTI odometry 04", "lidar-default", "grids", ("kitti_odo04", "21", "occupancy", "all"),
     {"AUC": "AUC {}", "log-loss": "log-loss {}"}),
    ("Hidden obstacles found at 1 % false alarms, KITTI raw 0009: this library", "lidar-default", "grids",
     ("kitti_raw0009", "16", "observed", "all"), {"hidden: recall at 1 %": "{}"}),
    ("… ray casting on the same disparities", "other-methods", "kitti_raw0009", ("`ray_casting`", "all"), {"hidden: recall at 1 %": "{}"}),
    ("Lanes that four drives drove over later, seen 4–13 m ahead", "lane", "", ("", "occupancy"), {"free": "free {}", "occupied": "occupied {}"}),
    ("Moving objects, eight rendered streets that nothing was chosen on", "obstacles-streets-left-out", "motion", ("scene:street",),
     {"found": "found {}", "speed error, m/s": "speed error {} m/s", "direction error, °": "direction error {}°"}),
    ("… rendered crossing", "exact-truth", "motion", ("B-crossing",),
     {"found": "found {}", "speed error, m/s": "speed error {} m/s", "direction error, °": "direction error {}°"}),
    ("Visual odometry, drift over KITTI odometry 04 (41 frames)", "odometry", "", ("kitti_odo04",), {"error at the end, %": "{} %"}),
    ("`stereogrid run`, KITTI 1226 × 370 px, two cores, images and grids on disk", "run", "", ("all layers", "400"),
     {"frames a second": "{} frames/s"}),
    ("Pipeline alone, 512 × 320 px, with AVX2", "chain", "", ("default, AVX2",), {"total": "{} ms per frame (least / median)"}),
    ("… with a GPU", "gpu-chain", "", ("default, GPU",), {"total": "{} ms per frame (least / median)"}),
)
IN_SAMPLE = "† In-sample: constants were fitted, or options chosen, on this input."

# figures of docs/: input and options of the run, number of its first frame there, number of frames
FIGURES = {
    "crossing": (("scene:crossing?frames=40&width=1242&height=375",), 6, 28),
    "street": (("scene:street?frames=60&width=1242&height=375", "--frames=0:27"), 25, 1),
    "corridor": (("scene:corridor?frames=60&speed=0.6&camera_height=0.4&width=848&height=480&focal=424&baseline=0.05", "--preset=robot",
                  "--frames=0:22"), 20, 1),
    "drop": (("scene:course?frames=170", "--frames=0:130"), 128, 1),
}

# screens of docs/ros2.md: a scene with the camera's image size, field of view and baseline
INDOORS = "corridor?frames=16&speed=0.6&camera_height=0.4"
OUTDOORS = "street?frames=16"
SCREENS = {
    "camera_realsense": (f"{INDOORS}&width=848&height=480&focal=424&baseline=0.05", "--preset=robot"),
    "camera_oak": (f"{INDOORS}&width=640&height=400&focal=401&baseline=0.075", "--preset=robot"),
    "camera_zed": (f"{OUTDOORS}&width=960&height=540&focal=478&baseline=0.12&camera_height=1", "--preset=default"),
    "camera_pair": (f"{OUTDOORS}&width=640&height=480&focal=520&baseline=0.3&camera_height=1", "--preset=default"),
}


def summary(values: list) -> str:
    """One value as it is; the sums of counts "a of b"; else the least and the greatest."""
    counts = [re.fullmatch(r"(\d+) of (\d+)", value) for value in values]
    if len(values) > 1 and all(counts):
        return " of ".join(str(sum(int(count[i]) for count in counts)) for i in (1, 2))
    return "–".join(dict.fromkeys((min(values, key=float), max(values, key=float)))) if len(values) > 1 else values[0]


def figure_row(label: str, name: str, title: str, first: tuple[str, ...], columns: dict[str, str]) -> str:
    measurement = results.load()[name]
    for table in measurement["tables"]:
        if title not in table["title"] or not columns.keys() <= set(table["columns"]):
            continue
        rows = [cells for cells in (list(map(results.cell_text, row)) for row in table["rows"])
                if all(start in ("", cell) or cell.startswith(start + "?") for cell, start in zip(cells, first))]
        if rows:
            values = ", ".join(form.format(summary([cells[table["columns"].index(column)] for cells in rows])) for column, form in columns.items())
            fitted = "\N{NO-BREAK SPACE}†" if results.in_sample(measurement, f"{table['title']} {rows[0][0]}") else ""
            mark = "".join(f" ({note.split(' (')[0].removeprefix('Measured ').rstrip('.')})" for note in measurement.get("notes", [])
                           if note.startswith("Measured before"))
            return f"| {label}{fitted} | {values} | {measurement['machine']} | {measurement['date']}{mark} |"
    raise ValueError(f"bench/results.json: {name}: no row {first} with columns {list(columns)}. Correct MEASURED in scripts/readme.py.")


def measured() -> str:
    rows = [figure_row(*entry) for entry in MEASURED]
    return "\n".join(["| measured | value | processor | date |", "| --- | --- | --- | --- |", *rows, "", IN_SAMPLE])


def snippet(name: str) -> str:
    """Body of an example file, without licence lines and the comment or docstring at its top."""
    text = (ROOT / name).read_text(encoding="utf-8")
    body = re.sub(r'\A(?:(?://|#(?!include)).*\n)*(?:"""[^"]*"""\n)?', "", text)
    return f"```{'python' if name.endswith('.py') else 'cpp'}\n{body.strip()}\n```"


def generated(readme: str) -> str:
    readme = re.sub(r"(<!-- snippet (\S+) -->\n)```.*?^```", lambda match: match[1] + snippet(match[2]), readme, flags=re.DOTALL | re.MULTILINE)
    return re.sub(r"(<!-- measured -->\n)(?:\|.*\n)*(?:\n†.*\n)?", lambda match: match[1] + measured() + "\n", readme)


def encode(source: list[str], name: str, options: str) -> None:
    """Writes docs/pictures/NAME.webp with ffmpeg; source: its options for the input."""
    subprocess.run(["ffmpeg", "-loglevel", "error", "-y", *source, *options.split(), ROOT / "docs" / "pictures" / f"{name}.webp"], check=True)


def render_figures() -> None:
    """Figures of runs, animated if they have several frames; grids of this library and of other methods behind an obstacle."""
    programs = ROOT / "build" / "release" / "bin"
    still, moving = "-vf scale=1200:-2:flags=area -quality 30", "-vf fps=5,scale=960:-2:flags=area -c:v libwebp_anim -loop 0 -quality 20"
    with tempfile.TemporaryDirectory() as folder:
        for name, (arguments, first, frames) in FIGURES.items():
            subprocess.run([programs / "stereogrid", "run", *arguments, "--out", f"{folder}/{name}", "--pictures", "-q"], check=True)
            encode(["-framerate", "10", "-start_number", str(first), "-i", f"{folder}/{name}/pictures/%06d.png"], name,
                   f"{moving if frames > 1 else still} -frames:v {(frames + 1) // 2} -compression_level 6")
        subprocess.run([ROOT / "research" / "compare.py", programs, "scene:occlusion?frames=8&width=1242&height=375", "--frames=0:6", "--figure",
                        f"{folder}/hidden.png", "--only", "observed,nearest_obstacle,free_space,ray_casting"], check=True)
        encode(["-i", f"{folder}/hidden.png"], "hidden", "-vf scale=1100:-1:flags=area -quality 30")


def render_screens() -> None:
    tool = ROOT / "build" / "release" / "bin" / "stereogrid"
    chromium = shutil.which("chromium") or shutil.which("google-chrome") or sys.exit("There is no Chromium. Install it.")
    for name, (scene, preset) in SCREENS.items():
        with tempfile.TemporaryDirectory() as folder:
            recording, screen = f"{folder}/drive.mcap", f"{folder}/screen.png"
            subprocess.run([tool, "run", f"scene:{scene}", preset, "--out", f"{folder}/run", "--mcap", recording, "-q"], check=True)
            with subprocess.Popen([tool, "view", recording, "--listen", ":0"], stdout=subprocess.PIPE, text=True) as view:
                page = re.search(r"http\S+", view.stdout.readline())[0]
                subprocess.run([chromium, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--window-size=1400,820",
                                "--virtual-time-budget=6000", f"--screenshot={screen}", f"{page}#frame=14"], check=True,
                               stderr=subprocess.DEVNULL)
                view.terminate()
            encode(["-i", screen], name, "-vf scale=1100:-1:flags=area -quality 30")


def main() -> int:
    if sys.argv[1:] in (["--figures"], ["--screens"]):
        render_figures() if sys.argv[1] == "--figures" else render_screens()
        return 0
    if sys.argv[1:] not in ([], ["--check"]):
        print(__doc__, file=sys.stderr)
        return 64
    present = README.read_text(encoding="utf-8")
    if sys.argv[1:] == []:
        README.write_text(generated(present), encoding="utf-8")
    elif present != generated(present):
        print("README.md differs from its sources (examples, bench/results.json). Run scripts/readme.py.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
