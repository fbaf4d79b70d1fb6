// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "matching/model.hpp"

namespace stereogrid {

/// Elements that the functions below read or write beyond a row's ends.
constexpr int row_overrun{64 + census_half_u};

/// Descriptors of a row, equal to `census`. `window` are the image rows v − census_half_v … v + census_half_v at u = 0.
void census_row(const std::uint8_t* const* window, int width, std::uint32_t* out);

/// Descriptors of a row, equal to the `bits` lowest of `short_census`. `window` are the image rows v −
/// short_census_half_v … v + short_census_half_v.
void short_census_row(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out);

/// The same from right to left.
void short_census_reversed(const std::uint8_t* const* window, int width, int bits, std::uint8_t* out);

/// A row of the right image as the road hypothesis sees it, equal to `sheared`.
void shear_row(const std::uint8_t* right_row, int width, const RoadRow& road, std::uint8_t* out);

}  // namespace stereogrid
