// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "alignment/alignment.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};
constexpr int block{32};

// A block of pixels lies between the same two rows nearly always: then there is nothing to look up for each.
void align_row(View<const std::uint8_t> right, const OffsetRow& row, int v, std::uint8_t* aligned) {
  std::array<std::int32_t, block> places{};  // in 1/256 px
  int u{0};
  for (; u + block <= right.width; u += block) {
    std::int32_t others{0};
    for (int k{0}; k < block; ++k) {
      places[static_cast<std::size_t>(k)] = v * 256 + row.at(u + k);
      others |= places[static_cast<std::size_t>(k)] ^ places[0];
    }
    if (others > 255 || others < 0) {
      for (int k{u}; k < u + block; ++k) aligned[k] = aligned_pixel(right, k, v, row);
      continue;
    }
    const int top{places[0] >> 8};
    const std::uint8_t* upper{right.row(std::clamp(top, 0, right.height - 1)) + u};
    const std::uint8_t* lower{right.row(std::clamp(top + 1, 0, right.height - 1)) + u};
    for (int k{0}; k < block; ++k) {
      aligned[u + k] = between_rows(upper[k], lower[k], places[static_cast<std::size_t>(k)] & 255);
    }
  }
  for (; u < right.width; ++u) aligned[u] = aligned_pixel(right, u, v, row);
}

}  // namespace

void align_rows(Cpu& cpu, View<const std::uint8_t> right, const RowOffsets& offsets, View<std::uint8_t> aligned) {
  cpu.for_ranges(right.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) align_row(right, offset_row(offsets, v), v, aligned.row(v));
  });
}

}  // namespace stereogrid
