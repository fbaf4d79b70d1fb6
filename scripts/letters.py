#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the outlines of the letters that visualisations draw.

letters.py FONT.ttf > apps/stereogrid/pictures/roboto.cpp

The font is Roboto Regular (Apache-2.0; Debian: fonts-roboto-unhinted). Needs fontTools (Debian: python3-fonttools).
"""
from __future__ import annotations

import sys

from fontTools.pens.basePen import BasePen
from fontTools.ttLib import TTFont

LETTERS = [chr(code) for code in range(0x20, 0x7F)] + list("°−≤≥")
UNITS = 512  # per em
PIECES = 3  # straight lines to a curve

HEAD = """// SPDX-License-Identifier: Apache-2.0
// Written by scripts/letters.py.
#include "pictures/canvas.hpp"

namespace stereogrid::app {{

// clang-format off
const std::array<Letter, {count}> roboto{{{{
{rows}
}}}};
// clang-format on

}}  // namespace stereogrid::app"""


class Flattened(BasePen):
    """Contours of a glyph as straight lines."""

    def __init__(self, glyphs: object) -> None:
        super().__init__(glyphs)
        self.contours: list[list[tuple[float, float]]] = []

    def _moveTo(self, point: tuple[float, float]) -> None:
        self.contours.append([point])

    def _lineTo(self, point: tuple[float, float]) -> None:
        self.contours[-1].append(point)

    def _qCurveToOne(self, control: tuple[float, float], end: tuple[float, float]) -> None:
        start = self.contours[-1][-1]
        for t in (i / PIECES for i in range(1, PIECES + 1)):
            weights = ((1 - t) ** 2, 2 * t * (1 - t), t**2)
            corners = zip(weights, (start, control, end))
            self.contours[-1].append(tuple(map(sum, zip(*((w * x, w * y) for w, (x, y) in corners)))))


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 64
    font = TTFont(sys.argv[1])
    scale = UNITS / font["head"].unitsPerEm
    rows = []
    for letter in LETTERS:
        glyph = font.getBestCmap()[ord(letter)]
        pen = Flattened(font.getGlyphSet())
        font.getGlyphSet()[glyph].draw(pen)
        lines = [" ".join(f"{round(x * scale)},{round(y * scale)}" for x, y in contour) for contour in pen.contours]
        rows.append(f'    {{0x{ord(letter):04X}, {round(font["hmtx"][glyph][0] * scale)}, "{";".join(lines)}"}},')
    print(HEAD.format(count=len(rows), rows="\n".join(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
