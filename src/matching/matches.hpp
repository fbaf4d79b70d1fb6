// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/image.hpp"

namespace stereogrid {

/// What `match` leaves: two disparity images (px, 0 = none); no pixel has both.
struct Matches {
  Matches(int width, int height) : obstacle{width, height}, road{width, height} {}

  Image<float> obstacle;
  Image<float> road;
};

}  // namespace stereogrid
