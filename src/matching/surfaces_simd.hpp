// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace stereogrid {

/// Relations of the pixels of a row to their neighbours, a bit each, pixel 0's the lowest of the first word. Words
/// cover pixel `width`, too, which none continues.
struct SurfaceBits {
  std::vector<std::uint64_t> is_measured;      ///< there is a disparity
  std::vector<std::uint64_t> continues_left;   ///< same label as the pixel before, disparities within 1 px
  std::vector<std::uint64_t> continues_above;  ///< likewise with the pixel above
};

/// Joins a row's two disparity images (px, 0 = none) in `labelled`: obstacle disparity, minus road disparity, or 0.
/// Finds neighbours on one surface. `labelled` and `above`, the row above in the same form, begin with a 0 before the
/// row and end with 64 zeros.
void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   SurfaceBits& bits);

}  // namespace stereogrid
