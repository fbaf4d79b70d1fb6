// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <cstdint>

#include "images/row_alignment/row_alignment.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};

void align_row(View<const std::uint8_t> right, const RowOffsets& offsets, int v, std::uint8_t* aligned) {
  for (int u{0}; u < right.width; u += offset_columns) {
    const int place{place_256(offsets, u, v)};
    const std::uint8_t* upper{right.row(std::clamp(place >> 8, 0, right.height - 1)) + u};
    const std::uint8_t* lower{right.row(std::clamp((place >> 8) + 1, 0, right.height - 1)) + u};
    const auto blend = [&](int count) {
      for (int k{0}; k < count; ++k) aligned[u + k] = between_rows(upper[k], lower[k], place & 255);
    };
    // a number known beforehand, for the compiler's vectors
    if (u + offset_columns <= right.width) {
      blend(offset_columns);
    } else {
      blend(right.width - u);
    }
  }
}

}  // namespace

void align_rows(Cpu& cpu, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned) {
  cpu.for_ranges(right.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) align_row(right, offsets, v, aligned.row(v));
  });
}

}  // namespace stereogrid
