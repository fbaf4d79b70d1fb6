#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks references to documents: relative links of Markdown files, and pages and their sections that any file names, such
as "docs/method.md §5.3". Generated pages of the site count as files. Part of check.py."""
import re
import subprocess
import sys
from functools import lru_cache
from pathlib import Path

LINK = re.compile(r"\]\(([^()\s]+)\)")
CODE_BLOCK = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
PAGE = re.compile(r"(?<![\w/.-])docs/[\w/-]+\.md")
SECTIONS = re.compile(r"(docs/[\w/-]+\.md)((?:(?: |,|and|\([^()\n]*\))*§\d+(?:\.\d+)*)+)")


# page of the site: script that prints it (scripts/mkdocs_hooks.py)
GENERATED = {f"docs/{name}.md": f"scripts/{name}.py" for name in ("constants", "gallery", "results")}
FIGURES = "bench/results.json"  # links to it lead to docs/results.md on the site, anchors included


def generator(root: Path, file: Path) -> "Path | None":
    names = (name for name in GENERATED if (root / name).resolve() == file.resolve())
    return next((root / GENERATED[name] for name in names if (root / GENERATED[name]).is_file()), None)


@lru_cache(maxsize=None)
def headings(root: Path, path: Path) -> tuple[str, ...]:
    if path.is_file():
        text = path.read_text(encoding="utf-8")
    elif script := generator(root, path):
        text = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True).stdout
    else:
        return ()
    text = CODE_BLOCK.sub("", text)
    return tuple(match[1].strip() for match in re.finditer(r"^#+ (.+)$", text, re.MULTILINE))


def anchor_of(heading: str) -> str:
    """As GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def bad_link(root: Path, name: str, target: str) -> "str | None":
    path, _, anchor = target.partition("#")
    file = (root / name).parent / path if path else root / name
    if anchor and file.resolve() == (root / FIGURES).resolve():
        file = root / "docs" / "results.md"
    if not file.exists() and not generator(root, file):
        return f"links to {target}, which is not there"
    if anchor and file.suffix == ".md" and anchor not in map(anchor_of, headings(root, file)):
        return f"links to {target}, but no heading has that anchor"
    return None


def bad_section(root: Path, page: str, number: str) -> "str | None":
    if any(heading.split()[0] == number for heading in headings(root, root / page)):
        return None
    return f"names section {number} of {page}, which has none"


def line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def violations(root: Path, name: str, text: str) -> list[str]:
    found = []
    if name.endswith(".md"):
        shown = CODE_BLOCK.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
        for match in LINK.finditer(shown):
            if not re.match(r"[a-z]+:", match[1]) and (sentence := bad_link(root, name, match[1])):
                found.append(f"{name}:{line_of(text, match.start())}: {sentence}")
    for match in PAGE.finditer(text):
        if not (root / match[0]).is_file() and not generator(root, root / match[0]):
            found.append(f"{name}:{line_of(text, match.start())}: names {match[0]}, which is not there")
    for match in SECTIONS.finditer(text):
        for number in re.findall(r"§([\d.]*\d)", match[2]):
            if sentence := bad_section(root, match[1], number):
                found.append(f"{name}:{line_of(text, match.start())}: {sentence}")
    return found
