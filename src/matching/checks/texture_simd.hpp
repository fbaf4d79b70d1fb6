// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "matching/padded.hpp"
#include "memory_bytes.hpp"

namespace stereogrid {

/// Working memory of texture_rows.
struct TextureWorkspace {
  TextureWorkspace() = default;
  TextureWorkspace(int width, int half_window);

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(columns, fours); }

  std::vector<std::uint16_t> columns;  ///< [half_window + u]: contrast summed over the window's rows
  std::vector<std::int32_t> fours;     ///< [u]: sums of four columns
};

/// textured = 1 where the window's sum of |L(u+1) − L(u−1)| is at least `least`, else 0, for the rows begin … end − 1;
/// the border is repeated.
void texture_rows(const Padded<std::uint8_t>& left, int half_window, std::int32_t least, int begin, int end,
                  TextureWorkspace& space, Padded<std::uint8_t>& textured);

}  // namespace stereogrid
