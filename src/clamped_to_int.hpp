// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host_device.hpp"

namespace stereogrid {

/// So far from 0 that no image and no grid has such a place, and so near to it that two of them and an index of an
/// image or a grid can be added up.
constexpr int far_int{1'000'000'000};

/// Truncates towards zero, as static_cast, which is undefined for numbers outside of int: here they become ± `limit`,
/// and NaN 0. Use it for every number from an input, a clock or a pose, unless earlier lines limit its range.
STEREOGRID_HD inline int clamped_to_int(double value, int limit = far_int) {
  if (value >= limit) return limit;
  if (value <= -limit) return -limit;
  return value == value ? static_cast<int>(value) : 0;
}

}  // namespace stereogrid
