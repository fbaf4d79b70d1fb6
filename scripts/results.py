#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the documentation site's page of measurements: those of bench/results.json, which scripts/measure.py writes."""
import json
import re
from decimal import Decimal
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "bench" / "results.json"
SECTIONS = ("Grids against lidar", "Grids and motion against exact truth", "Obstacles", "Odometry", "Time", "GPU")
ACCURACY = ("Grids against lidar", "Grids and motion against exact truth", "Obstacles")
# data on which the ray weights are fitted (src/observation/rays/weights.hpp) and options were chosen
FITTED = re.compile(r"\b(kitti_odo04|kitti_raw0009|B[- ]crossing|C[- ]street|E[- ]like KITTI|E-kitti-like)\b")
# fields of a measurement, in the order of the file; "notes" may be missing
FIELDS = {"section": str, "title": str, "about": str, "date": str, "commit": str, "machine": str, "command": str,
          "tables": list}
HEAD = """# Measured

Made by `scripts/results.py` from [bench/results.json](../bench/results.json). `scripts/measure.py` renews a measurement. Each
one holds for its commit and machine. What is not named is at its default.

Data: parts of KITTI odometry sequence 04 (41 frames) and of the raw drives 2011_09_26_0009 (31) and 0001 (20); the
rendered sequences A to E with exact truth (512 × 320 px with f·b = 90 px·m; E: 1242 × 375 px with 390 px·m).
[evaluation.md](evaluation.md) defines the scores.

† In-sample: constants were fitted, or options chosen, on this input. Rows without it are of inputs that nothing was fitted on. The figures to
quote are those of [weights fitted without the input](#ray-weights-fitted-without-the-input).
"""


def check(name: str, measurement: dict) -> None:
    for field, kind in FIELDS.items():
        if not isinstance(measurement.get(field), kind) or not measurement[field]:
            raise ValueError(f"{name}: '{field}' is missing or of another type")
    if measurement["section"] not in SECTIONS:
        raise ValueError(f"{name}: there is no section '{measurement['section']}'; {', '.join(SECTIONS)}")
    if not re.fullmatch(r"\d{4}-\d\d-\d\d", measurement["date"]):
        raise ValueError(f"{name}: invalid date '{measurement['date']}'")
    for table in measurement["tables"]:
        if any(len(row) != len(table["columns"]) for row in table["rows"]):
            raise ValueError(f"{name}: a row of '{table['title']}' has not as many cells as there are columns")


def load() -> dict:
    """Measurements by name; their numbers are Decimals, which keep the digits that were written."""
    measurements = json.loads(FILE.read_text(encoding="utf-8"), parse_float=Decimal, parse_int=Decimal)
    for name, measurement in measurements.items():
        check(name, measurement)
    return measurements


def literal(value) -> str:
    return str(value) if isinstance(value, Decimal) else json.dumps(value, ensure_ascii=False)


def measurement_json(measurement: dict) -> str:
    """Its texts in the first line, then a table or note per line."""
    def in_lines(values: list) -> str:
        return "[" + ",".join(f"\n  {value}" for value in values) + "]"

    texts = [f"{literal(field)}: {literal(measurement[field])}" for field in FIELDS if field != "tables"]
    tables = [f'{{"title": {literal(table["title"])}, "columns": {literal(table["columns"])}, "rows": ['
              + ", ".join("[" + ", ".join(map(literal, row)) + "]" for row in table["rows"]) + "]}"
              for table in measurement["tables"]]
    notes = [f'"notes": {in_lines(map(literal, measurement["notes"]))}'] if measurement.get("notes") else []
    return "{" + ",\n ".join([", ".join(texts), f'"tables": {in_lines(tables)}', *notes]) + "}"


def save(measurements: dict) -> None:
    texts = [f"{literal(name)}: {measurement_json(measurements[name])}" for name in sorted(measurements)]
    FILE.write_text("{\n" + ",\n".join(texts) + "\n}\n", encoding="utf-8")


def cell_text(value) -> str:
    return "–" if value is None else str(value)


def in_sample(measurement: dict, text: str) -> bool:
    """Whether a figure is of accuracy on an input that constants were fitted on, which the text names."""
    return measurement["section"] in ACCURACY and "fitted without" not in measurement["title"] and bool(FITTED.search(text))


def table_text(table: dict, measurement: dict) -> str:
    marked = ([f"{row[0]}\N{NO-BREAK SPACE}†", *row[1:]] if in_sample(measurement, cell_text(row[0])) else row for row in table["rows"])
    rows = [table["columns"], ["---"] * len(table["columns"]), *marked]
    title = f"**{table['title']}**\n\n" if table["title"] else ""
    return title + "\n".join("| " + " | ".join(map(cell_text, row)) + " |" for row in rows)


def source_text(measurement: dict) -> str:
    """Source of a measurement. States of older ones the facts that scripts/measure.py now records or rejects."""
    commit, machine = measurement["commit"], measurement["machine"]
    if commit.endswith("+"):
        commit = f"{commit[:-1]} with changes that were not committed"
    if "family" not in machine:
        machine += " (model and SIMD target not recorded)"
    return f"`{measurement['command']}`, {measurement['date']}, commit {commit}, {machine}."


def measurement_text(measurement: dict) -> str:
    parts = [f"### {measurement['title']}", measurement["about"], 
             *(table_text(table, measurement) for table in measurement["tables"])]
    if measurement.get("notes"):
        parts.append("\n".join("* " + note for note in measurement["notes"]))
    return "\n\n".join([*parts, source_text(measurement)])


def page() -> str:
    measurements = [measurement for _, measurement in sorted(load().items())]
    parts = [HEAD]
    for section in SECTIONS:
        if texts := [measurement_text(one) for one in measurements if one["section"] == section]:
            parts.append("\n\n".join([f"## {section}", *texts]) + "\n")
    return "\n".join(parts)


if __name__ == "__main__":
    print(page(), end="")
