// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>

#include "images/row_alignment/row_alignment.hpp"

namespace stereogrid {

void align_rows(Reference&, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned) {
  const auto row = [&](int v) { return right.row(std::clamp(v, 0, right.height - 1)); };
  for (int v{0}; v < right.height; ++v) {
    for (int u{0}; u < right.width; ++u) {
      const int place{place_256(offsets, u, v)};
      aligned(u, v) = between_rows(row(place >> 8)[u], row((place >> 8) + 1)[u], place & 255);
    }
  }
}

}  // namespace stereogrid
