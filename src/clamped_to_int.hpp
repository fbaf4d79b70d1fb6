// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host_device.hpp"

namespace stereogrid {

/// So far from 0 that no image and no grid has such a place, and so near to it that two of them and an index of an
/// image or a grid can be added up.
constexpr int far_int{1'000'000'000};

/// Towards zero, as static_cast does, which is undefined for a number that an int does not hold: beyond ± `limit` it is
/// ± `limit` here, and 0 for what is no number. Every number that comes from an input, a clock or a pose becomes an int
/// in this way, unless the lines before keep it within bounds.
STEREOGRID_HD inline int clamped_to_int(double value, int limit = far_int) {
  if (value >= limit) return limit;
  if (value <= -limit) return -limit;
  return value == value ? static_cast<int>(value) : 0;
}

}  // namespace stereogrid
