#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every exported name of the public headers has a comment; overloads on successive lines share one."""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def uncommented(text: str):
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        found = re.match(r"(?:\[\[nodiscard\]\] |class |struct )*STEREOGRID_EXPORT (?:.*?(\w+)\(|(\w+))", line)
        if not found:
            continue
        above = number - 2
        while above >= 0 and (re.match(r"(template|requires)\b", lines[above]) or f" {found[1] or '?'}(" in lines[above]):
            above -= 1
        if above < 0 or not lines[above].startswith("///"):
            yield f"{number}: {line.strip()}"


def main():
    assert list(uncommented("/// A.\nSTEREOGRID_EXPORT int a();\nSTEREOGRID_EXPORT int a(int);")) == []
    assert list(uncommented("/// A.\nstruct A {};\n[[nodiscard]] STEREOGRID_EXPORT int a();")) != []
    found = [f"{header.relative_to(ROOT)}:{fault}" for header in sorted(ROOT.glob("**/include/stereogrid/**/*.hpp"))
             if "build" not in header.relative_to(ROOT).parts for fault in uncommented(header.read_text("utf-8"))]
    print("\n".join(found) or "every exported name has a comment")
    sys.exit(bool(found))


main()
