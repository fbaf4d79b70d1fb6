// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace stereogrid {

/// Covariances of a pose that was estimated, 3 × 3 row-major over x, y (m) and heading (rad).
struct PoseCovariances {
  std::array<double, 9> pose{};    ///< covariance of world_from_vehicle, world axes; 0 at the first frame
  std::array<double, 9> motion{};  ///< covariance of the motion since the frame before, vehicle axes of this frame
};

}  // namespace stereogrid
