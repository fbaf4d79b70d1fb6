// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace stereogrid {

/// Relations of a pixel to its neighbours: bits of `flag_surfaces`.
constexpr std::uint8_t is_measured{1};      ///< there is a disparity
constexpr std::uint8_t continues_left{2};   ///< same label as the pixel before, disparities within 1 px
constexpr std::uint8_t continues_above{4};  ///< likewise with the pixel above

/// Joins a row's two disparity images (px, 0 = none) in `labelled`: obstacle disparity, minus road disparity, or 0.
/// Sets flags for neighbours on one surface. `labelled` and `above`, the row above in the same form, begin with a 0
/// before the row; all arrays are padded by 64 elements.
void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   std::uint8_t* flags);

}  // namespace stereogrid
