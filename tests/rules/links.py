#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Checks what files say about documents: relative links of Markdown files, and pages and their sections that any file
names, such as "docs/method.md §5.3". Part of check.py."""
import re
from functools import lru_cache
from pathlib import Path

LINK = re.compile(r"\]\(([^()\s]+)\)")
CODE_BLOCK = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
PAGE = re.compile(r"(?<![\w/.-])docs/[\w/-]+\.md")
SECTIONS = re.compile(r"(docs/[\w/-]+\.md)((?:(?: |,|and|\([^()\n]*\))*§\d+(?:\.\d+)*)+)")


@lru_cache(maxsize=None)
def headings(path: Path) -> tuple[str, ...]:
    if not path.is_file():
        return ()
    text = CODE_BLOCK.sub("", path.read_text(encoding="utf-8"))
    return tuple(match[1].strip() for match in re.finditer(r"^#+ (.+)$", text, re.MULTILINE))


def anchor_of(heading: str) -> str:
    """As GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def bad_link(root: Path, name: str, target: str) -> "str | None":
    path, _, anchor = target.partition("#")
    file = (root / name).parent / path if path else root / name
    if not file.exists():
        return f"links to {target}, which is not there"
    if anchor and file.suffix == ".md" and anchor not in map(anchor_of, headings(file)):
        return f"links to {target}, but no heading has that anchor"
    return None


def bad_section(root: Path, page: str, number: str) -> "str | None":
    if any(heading.split()[0] == number for heading in headings(root / page)):
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
        if not (root / match[0]).is_file():
            found.append(f"{name}:{line_of(text, match.start())}: names {match[0]}, which is not there")
    for match in SECTIONS.finditer(text):
        for number in re.findall(r"§([\d.]*\d)", match[2]):
            if sentence := bad_section(root, match[1], number):
                found.append(f"{name}:{line_of(text, match.start())}: {sentence}")
    return found
