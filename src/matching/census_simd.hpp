// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "matching/model.hpp"

namespace stereogrid {

/// Pixels that may be read on either side of a row given to census_row, beyond the window's own reach.
constexpr int census_padding{64};

/// Descriptors of one row, bit-equal to `census` of model.hpp. `window[j]` is the row j − census_half_v away; columns
/// −census_half_u … width + census_half_u − 1 carry the image with its border repeated, and census_padding more on the
/// right may be read. `out` has room for a multiple of census_padding.
void census_row(const std::uint8_t* const* window, int width, std::uint32_t* out);

}  // namespace stereogrid
