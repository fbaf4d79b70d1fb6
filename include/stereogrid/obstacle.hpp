// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace stereogrid {

/// Symmetric, 2 × 2.
struct Covariance2 {
  double xx{0};
  double xy{0};
  double yy{0};
};

/// A tracked thing: occupied cells that move alike. Positions in the vehicle frame of the same instant; velocities
/// relative to the ground, in vehicle axes.
struct Obstacle {
  std::int64_t id{0};  ///< stays with the obstacle for as long as it is tracked; never used again
  double x_m{0};       ///< centre of the occupied cells
  double y_m{0};
  double vx_mps{0};
  double vy_mps{0};
  double length_m{0};   ///< extent along yaw_rad
  double width_m{0};    ///< extent across yaw_rad
  double yaw_rad{0};    ///< of the motion where it moves, else of the longer side
  double occupancy{0};  ///< mean P(occupied) of its cells
  double age_s{0};      ///< since it was first seen
  bool confirmed{false};
  bool moving{false};               ///< faster than 1 m/s, and than two standard deviations of its speed
  bool coasting{false};             ///< not seen in this frame: carried on where it was hidden or missed
  double unseen_s{0};               ///< since it was last seen
  Covariance2 position_covariance;  ///< m², vehicle axes
  Covariance2 velocity_covariance;  ///< m²/s², vehicle axes
};

}  // namespace stereogrid
