# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Hooks of mkdocs.yml: links to files outside of docs/ become plain text (tests/rules/links.py checks those), and the pages of
constants and of results are generated."""
import re

from constants import page as constants_page
from mkdocs.structure.files import File
from results import page as results_page


def on_files(files, config):
    files.append(File.generated(config, "constants.md", content=constants_page()))
    files.append(File.generated(config, "results.md", content=results_page()))
    return files


def on_page_markdown(markdown, page, **_):
    depth = page.file.src_uri.count("/")
    return re.sub(rf"(?<!!)\[([^\]]+)\]\((?:\.\./){{{depth + 1}}}[^)]*\)", r"\1", markdown)
