// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "held_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Result of `match`: two disparity images (px, 0 = none); no pixel has both.
struct Matches {
  Matches(int width, int height) : obstacle{width, height}, road{width, height}, confidence{width, height} {}

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(obstacle, road, confidence); }

  Image<float> obstacle;
  Image<float> road;
  Image<float> confidence;  ///< probability in [0, 1] that the disparity is right to a pixel; 0 where there is none
};

}  // namespace stereogrid
