# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Hook of mkdocs.yml: links to files outside of docs/ become plain text. tests/rules/links.py checks those."""
import re


def on_page_markdown(markdown, page, **_):
    depth = page.file.src_uri.count("/")
    return re.sub(rf"(?<!!)\[([^\]]+)\]\((?:\.\./){{{depth + 1}}}[^)]*\)", r"\1", markdown)
