# SPDX-License-Identifier: Apache-2.0
"""Finds research/figures, or ends a test as skipped where Matplotlib or the package is missing."""
import sys
from pathlib import Path

try:
    import matplotlib
    import numpy
    import stereogrid  # noqa: F401
except ImportError as error:
    print(f"skipped: {error.name} is not installed")
    sys.exit(77)

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "research" / "figures"))
