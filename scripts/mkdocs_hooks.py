# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Hooks of mkdocs.yml: links to files outside of docs/ become plain text (tests/rules/links.py checks those), and the page
of constants is made of the source."""
import re

from constants import page as constants_page
from mkdocs.structure.files import File


def on_files(files, config):
    files.append(File.generated(config, "constants.md", content=constants_page()))
    return files


def on_page_markdown(markdown, page, **_):
    depth = page.file.src_uri.count("/")
    return re.sub(rf"(?<!!)\[([^\]]+)\]\((?:\.\./){{{depth + 1}}}[^)]*\)", r"\1", markdown)
