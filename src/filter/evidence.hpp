// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/model.hpp"

namespace stereogrid {

/// What has been measured of the velocity of that which occupies a cell. World axes.
struct VelocityEvidence {
  int cell;  ///< iy · nx + ix of the window
  float x;   ///< m/s
  float y;
  float xx;  ///< inverse of its covariance, s²/m²
  float xy;
  float yy;
};

/// The least that evidence says: now and then something else has been measured.
constexpr float likelihood_floor{0.02f};

/// Likelihood of what has been measured, where the velocity is (vx, vy). Its tails end on a floor.
STEREOGRID_HD inline float likelihood_of(const VelocityEvidence& evidence, float vx_mps, float vy_mps) {
  const float x{vx_mps - evidence.x};
  const float y{vy_mps - evidence.y};
  const float squared_distance{evidence.xx * x * x + 2 * evidence.xy * x * y + evidence.yy * y * y};
  const float near{1 / (1 + 0.5f * squared_distance)};
  return likelihood_floor + near * near;
}

/// A cell's masses after the evidence.
struct WeighedCell {
  VelocitySums sums;
  float standing;
};

/// Bayes' rule over the lattice's velocities, given that the cell is occupied: P(occupied) stays. `mass(k)`: a
/// reference to m(k).
template <class Mass>
STEREOGRID_HD inline WeighedCell weigh(const VelocityEvidence& evidence, const float* axis_mps, int side,
                                       const Mass& mass) {
  float before{0};
  float after{0};
  for (int j{0}; j < side; ++j) {
    float row_before{0};
    float row_after{0};
    for (int i{0}; i < side; ++i) {
      float& m{mass(j * side + i)};
      row_before += m;
      m *= likelihood_of(evidence, axis_mps[i], axis_mps[j]);
      row_after += m;
    }
    before += row_before;
    after += row_after;
  }
  const float scale{after > 0 ? before / after : 1.0f};
  WeighedCell cell{};
  for (int j{0}; j < side; ++j) {
    float row_mass{0};
    float row_x{0};
    float row_xx{0};
    for (int i{0}; i < side; ++i) {
      float& m{mass(j * side + i)};
      m *= scale;
      row_mass += m;
      row_x += axis_mps[i] * m;
      row_xx += axis_mps[i] * axis_mps[i] * m;
    }
    cell.sums.add_row(axis_mps[j], row_mass, row_x, row_xx);
  }
  cell.standing = mass(side * side / 2);
  return cell;
}

}  // namespace stereogrid
