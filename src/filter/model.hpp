// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "host_device.hpp"

namespace stereogrid {

/// Constants of one filter step.
struct FilterStep {
  int velocities;          ///< K, odd square: the lattice; its middle is standstill
  float forgetting;        ///< eps of method §2.3, from the time constant and the time step
  float kept_moving;       ///< share of a moving velocity's mass that keeps it: 1 − mu
  float kept_standing;     ///< share of the standing mass that goes on standing
  float spread;            ///< share of all moving mass that each moving velocity gains
  float start;             ///< share of the standing mass that each moving velocity gains
  float stop;              ///< share of the moving mass that comes to stand
  float border_occupancy;  ///< of cells outside the window
  float prior_static;      ///< prior of standstill for new mass
  float prior_moving;      ///< prior of every other velocity for new mass
};

STEREOGRID_HD inline float prior_of(const FilterStep& step, int k) {
  return k == step.velocities / 2 ? step.prior_static : step.prior_moving;
}

/// Velocity noise: mass of one velocity after it, from the mass of that velocity, of all velocities and of standstill.
STEREOGRID_HD inline float disturbed(const FilterStep& step, float mass, float all, float standing) {
  return step.kept_moving * mass + step.spread * (all - standing) + step.start * standing;
}
STEREOGRID_HD inline float disturbed_standing(const FilterStep& step, float standing, float all) {
  return step.kept_standing * standing + step.stop * (all - standing);
}

/// Bilinear weights of a displacement that is not a whole number of cells: the mass of cell c comes from the four cells
/// around c − shift.
struct Antecedents {
  int ix;  ///< whole part of −shift: from[i] lies at c + ix (+1)
  int iy;
  float w00, w10, w01, w11;
};

STEREOGRID_HD inline int floor_of(double value) {
  const int truncated{static_cast<int>(value)};
  return truncated > value ? truncated - 1 : truncated;
}

/// Antecedents of every cell for a displacement of (shift_x, shift_y) cells, read from a window that has since moved by
/// (moved_x, moved_y) whole cells.
STEREOGRID_HD inline Antecedents antecedents(double shift_x, double shift_y, int moved_x, int moved_y) {
  const int ix{floor_of(-shift_x)};
  const int iy{floor_of(-shift_y)};
  const float fx{static_cast<float>(-shift_x - ix)};
  const float fy{static_cast<float>(-shift_y - iy)};
  return {ix + moved_x, iy + moved_y, (1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
}

/// The likelihoods of an observed probability p formed with prior ½: (p, 1 − p), tempered. method §2.3.
struct Likelihood {
  float occupied;
  float empty;
};

}  // namespace stereogrid
