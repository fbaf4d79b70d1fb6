// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include "alignment/alignment.hpp"

namespace stereogrid {

void align_rows(Reference&, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned) {
  for (int v{0}; v < right.height; ++v) {
    for (int u{0}; u < right.width; ++u) aligned(u, v) = aligned_pixel(right, u, v, offset_row(offsets, v));
  }
}

}  // namespace stereogrid
