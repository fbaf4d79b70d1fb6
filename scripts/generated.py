# SPDX-FileCopyrightText: 2026 The stereogrid authors
# SPDX-License-Identifier: Apache-2.0
"""Pages that scripts write: command line of such a script."""
import sys
from pathlib import Path


def write_or_check(page: Path, text: str, usage: str) -> int:
    """Writes `text` to `page`; with --check, returns 1 if the page differs. Other arguments: prints `usage`, returns 64."""
    if sys.argv[1:] == []:
        page.write_text(text, encoding="utf-8")
    elif sys.argv[1:] != ["--check"]:
        print(usage, file=sys.stderr)
        return 64
    elif page.read_text(encoding="utf-8") != text:
        print(f"docs/{page.name} differs from its sources. Run scripts/{Path(sys.argv[0]).name}.", file=sys.stderr)
        return 1
    return 0
