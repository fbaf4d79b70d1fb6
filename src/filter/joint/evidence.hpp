// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/model.hpp"

namespace stereogrid {

/// Measured velocity of the object that occupies a cell. World axes.
struct VelocityEvidence {
  int cell;  ///< iy · nx + ix of the window
  float x;   ///< m/s
  float y;
  float xx;  ///< inverse of its covariance plus the lattice's variances, s²/m²
  float xy;
  float yy;
  int is_repeated{0};    ///< 1: standstill explains it, and the camera sees the cell from where it did a frame ago
  int starts_motion{0};  ///< 1: several features exclude standstill
  int is_static{0};      ///< 1: standstill explains it
};

/// Repeated evidence of standstill is not applied to a cell that the frame has not observed (`age_s` > 0): in every
/// frame the mass that arrives from neighbours would come to stand there, until the cell is occupied. No evidence of
/// standstill is applied to a cell that has never been observed: only dynamic mass makes it occupied. docs/method.md
/// §9.3.
STEREOGRID_HD inline bool is_ignored(const VelocityEvidence& evidence, float age_s) {
  return (evidence.is_repeated != 0 && age_s > 0) || (evidence.is_static != 0 && age_s > never_s);
}

/// Standing mass of a cell before the evidence. Features that exclude standstill start motion: a minimum share of
/// the mass is dynamic. With the prior of standstill, the likelihood's floor would keep the cell static for frames.
STEREOGRID_HD inline float standing_before(const VelocityEvidence& evidence, float occupancy, float standing) {
  constexpr float standing_max{0.5f};
  return evidence.starts_motion != 0 ? Min(standing, standing_max * occupancy) : standing;
}

/// A cell's masses after the evidence.
struct WeighedCell {
  VelocitySums sums;
  float standing;
};

/// Step of the lattice along an axis at a velocity.
template <class Real>
STEREOGRID_HD inline Real step_at(const Real* axis_mps, int side, Real v_mps) {
  if (side < 2) return 0;
  int i{0};
  while (i < side - 2 && axis_mps[i + 1] < v_mps) ++i;
  return axis_mps[i + 1] - axis_mps[i];
}

/// Variance along an axis of the velocities up to a step away that a velocity of the lattice stands for.
template <class Real>
STEREOGRID_HD inline Real lattice_variance(Real step_mps) {
  return step_mps * step_mps / 6;
}

/// Change of a velocity by one step of the lattice at most. `towards`: difference from the measurement, times its
/// information.
STEREOGRID_HD inline float within_step(float step, float towards) {
  return Min(Max(lattice_variance(step) * towards, -step), step);
}

/// Mean velocity of a cell: its dynamic part moves towards the measurement by the lattice's share of the variance,
/// unless that is of something else. docs/method.md §9.3.
STEREOGRID_HD inline VelocityEstimate refined(const VelocityEvidence& evidence, const float* axis_mps, int side,
                                              const WeighedCell& cell) {
  constexpr float dynamic_min{0.3f};
  constexpr float else_from{400};  // squared distance
  VelocityEstimate velocity{estimate_of(cell.sums)};
  const float moving{cell.sums.mass - cell.standing};
  if (moving <= dynamic_min * cell.sums.mass) return velocity;
  const float vx{cell.sums.x / moving};
  const float vy{cell.sums.y / moving};
  const float dx{evidence.x - vx};
  const float dy{evidence.y - vy};
  const float towards_x{evidence.xx * dx + evidence.xy * dy};
  const float towards_y{evidence.xy * dx + evidence.yy * dy};
  if (dx * towards_x + dy * towards_y > else_from) return velocity;
  const float share{moving / cell.sums.mass};
  velocity.x += share * within_step(step_at(axis_mps, side, vx), towards_x);
  velocity.y += share * within_step(step_at(axis_mps, side, vy), towards_y);
  return velocity;
}

/// Row of the lattice's mass, before and after weighing by the measurement.
struct RowWeight {
  float before{0};
  float after{0};
};

/// Weight of the row of velocities whose v_y is axis_mps[row]. `mass(k)`: m(k) before.
template <class Mass>
STEREOGRID_HD inline RowWeight weight_of_row(const VelocityEvidence& evidence, const float* axis_mps, int side, int row,
                                             const Mass& mass) {
  RowWeight weight;
  for (int i{0}; i < side; ++i) {
    const float m{mass(row * side + i)};
    weight.before += m;
    weight.after += m * likelihood_of(evidence, axis_mps[i], axis_mps[row]);
  }
  return weight;
}

/// The sums of such a row afterwards, and the mass in its middle.
struct WeighedRow {
  LatticeRowSums<float> sums;
  float middle{0};
};

/// `keep(k, m)`: takes m(k) afterwards.
template <class Mass, class Keep>
STEREOGRID_HD inline WeighedRow weigh_row(const VelocityEvidence& evidence, const float* axis_mps, int side, int row,
                                          float scale, const Mass& mass, const Keep& keep) {
  WeighedRow weighed;
  for (int i{0}; i < side; ++i) {
    const int k{row * side + i};
    const float m{mass(k) * likelihood_of(evidence, axis_mps[i], axis_mps[row]) * scale};
    weighed.sums.add(axis_mps[i], m);
    if (i == side / 2) weighed.middle = m;
    keep(k, m);
  }
  return weighed;
}

STEREOGRID_HD inline float scale_of(const RowWeight& all) {
  return all.after > 0 ? all.before / all.after : 1.0f;
}

/// Bayes' rule over the lattice's velocities, given that the cell is occupied: P(occupied) stays. `mass(k)`: m(k)
/// before; `keep(k, m)`: takes it afterwards.
template <class Mass, class Keep>
STEREOGRID_HD inline WeighedCell weigh(const VelocityEvidence& evidence, const float* axis_mps, int side,
                                       const Mass& mass, const Keep& keep) {
  RowWeight all;
  for (int row{0}; row < side; ++row) {
    const RowWeight weight{weight_of_row(evidence, axis_mps, side, row, mass)};
    all.before += weight.before;
    all.after += weight.after;
  }
  WeighedCell cell{};
  for (int row{0}; row < side; ++row) {
    const WeighedRow weighed{weigh_row(evidence, axis_mps, side, row, scale_of(all), mass, keep)};
    cell.sums.add(axis_mps[row], weighed.sums);
    if (row == side / 2) cell.standing = weighed.middle;
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
