#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the documentation site's page of constants: those of the source files in src/, with their comments."""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CONSTANT = re.compile(r"\s*constexpr (?:double|float) (\w+)\{(.+)\};\s*(?://+<? ?(.*))?$")
COMMENT = re.compile(r"\s*//+ ?(.*)$")
HEAD = """# Constants

Made by `scripts/constants.py` from the constants (`double`, `float`) of the files in `src/`. Parameters that users may set
are in [config.md](config.md). The comment is that of the code. It begins above a group of constants and names the data that a value was
chosen on, where there were some.
"""


def constants_of(path: Path) -> "list[tuple[str, str, str]]":
    """(name, value, comment) of each constant but limits of types. A comment is above its constant or at the end of its line."""
    found, above = [], []
    for line in path.read_text(encoding="utf-8").splitlines():
        if constant := CONSTANT.match(line):
            name, value, beside = constant.groups()
            if "numeric_limits" not in value:
                found.append((name, value, " ".join([*above, beside or ""]).strip()))
            above = []
        elif comment := COMMENT.match(line):
            above.append(comment[1])
        else:
            above = []
    return found


def page() -> str:
    parts = [HEAD]
    for path in sorted((ROOT / "src").rglob("*.cpp")):
        if constants := constants_of(path):
            rows = "".join(f"| `{name}` | {value} | {comment.replace('|', chr(92) + '|')} |\n" for name, value, comment in constants)
            parts.append(f"\n## {path.relative_to(ROOT / 'src')}\n\n| name | value | comment |\n| --- | --- | --- |\n{rows}")
    return "".join(parts)


if __name__ == "__main__":
    print(page(), end="")
