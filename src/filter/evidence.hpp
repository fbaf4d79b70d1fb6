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

/// A cell's masses after the evidence.
struct WeighedCell {
  VelocitySums sums;
  float standing;
};

/// Bayes' rule over the lattice's velocities, given that the cell is occupied: P(occupied) stays. `mass(k)`: m(k)
/// before; `keep(k, m)`: takes it afterwards.
template <class Mass, class Keep>
STEREOGRID_HD inline WeighedCell weigh(const VelocityEvidence& evidence, const float* axis_mps, int side,
                                       const Mass& mass, const Keep& keep) {
  float before{0};
  float after{0};
  for (int j{0}; j < side; ++j) {
    float row_before{0};
    float row_after{0};
    for (int i{0}; i < side; ++i) {
      const float m{mass(j * side + i)};
      row_before += m;
      row_after += m * likelihood_of(evidence, axis_mps[i], axis_mps[j]);
    }
    before += row_before;
    after += row_after;
  }
  const float scale{after > 0 ? before / after : 1.0f};
  WeighedCell cell{};
  for (int j{0}; j < side; ++j) {
    LatticeRowSums<float> row;
    for (int i{0}; i < side; ++i) {
      const int k{j * side + i};
      const float m{mass(k) * likelihood_of(evidence, axis_mps[i], axis_mps[j]) * scale};
      row.add(axis_mps[i], m);
      if (k == side * side / 2) cell.standing = m;
      keep(k, m);
    }
    cell.sums.add(axis_mps[j], row);
  }
  return cell;
}

/// The same of a cell without masses of its own.
STEREOGRID_HD inline WeighedCell weigh_evenly(const VelocityEvidence& evidence, const float* axis_mps, int side,
                                              float each, float standing) {
  const int standstill{side * side / 2};
  return weigh(
      evidence, axis_mps, side, [&](int k) { return k == standstill ? standing : each; }, [](int, float) {});
}

}  // namespace stereogrid
