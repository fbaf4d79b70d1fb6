// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "stereogrid/image.hpp"

namespace stereogrid {

/// Rows begin … end − 1 of an image, smoothed by the binomial of 3 × 3 pixels; the border repeats.
void smooth_rows(View<const std::uint8_t> image, int begin, int end, View<std::uint8_t> smoothed);

}  // namespace stereogrid
