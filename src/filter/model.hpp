// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clamped_to_int.hpp"
#include "host_device.hpp"
#include "numbers.hpp"

namespace stereogrid {

#include "filter/lattice_formulas.hpp"

/// Constants of one filter step.
struct FilterStep {
  int side;                  ///< the lattice has side × side velocities, y-major; odd: the middle one is standstill
  float forgetting;          ///< eps of docs/method.md §8.4, from the time constant and the time step
  float kept_moving;         ///< share of a moving velocity's mass that keeps it: 1 − mu
  float kept_standing;       ///< share of the standing mass that goes on standing
  float spread;              ///< share of all moving mass that each moving velocity gains
  float start;               ///< share of the standing mass that each moving velocity gains
  float stop;                ///< share of the moving mass that comes to stand
  float border_occupancy;    ///< of cells outside the window
  float prior_static;        ///< prior of standstill for new mass
  float prior_moving;        ///< prior of every other velocity for new mass
  float appearing_static;    ///< prior of standstill for what appears where the frame before has seen free ground
  float appearing_moving;    ///< prior of every other velocity for that
  float lattice_squares;     ///< Σ v_x² over the lattice, m²/s²
  float forgetting_in_view;  ///< likewise of cells within the camera's angle of view
  float camera_x;            ///< column and row of the cell in which the camera is
  float camera_y;
  float ahead_x;  ///< of length 1, where it looks
  float ahead_y;
  float view_left;          ///< cells to the left, for each cell ahead, that it sees; to the right
  float view_right;         ///< both negative: nothing is known of the camera
  float new_view_squares;   ///< within the root of so many squares of a cell around the camera the view is another one
  float moving_velocities;  ///< of the lattice, all but standstill
  float each_moving;        ///< one of them by their number; 0: there are none
  float moving_mass_min;    ///< from which on a cell moves
  int reach;                ///< cells that the fastest velocity goes along an axis

  STEREOGRID_HD int velocities() const { return side * side; }
  STEREOGRID_HD int standstill() const { return side * side / 2; }
};

STEREOGRID_HD inline float prior_of(const FilterStep& step, int k) {
  return k == step.standstill() ? step.prior_static : step.prior_moving;
}

/// Velocity noise is a Markov chain over the velocities: each keeps a share of its mass and gains what depends on the
/// cell alone. `all`: mass of all velocities, `standing`: that of standstill.
STEREOGRID_HD inline float gained_by_moving(const FilterStep& step, float all, float standing) {
  return step.spread * (all - standing) + step.start * standing;
}
STEREOGRID_HD inline float disturbed_standing(const FilterStep& step, float all, float standing) {
  return step.kept_standing * standing + step.stop * (all - standing);
}

/// Where the mass of a cell comes from for a displacement that is no whole number of cells: from[i] between the cells
/// ix and ix + 1 further along x, likewise along y.
struct Antecedents {
  int ix;  ///< whole part of −shift
  int iy;
  float fx;  ///< the rest, in [0, 1)
  float fy;
};

STEREOGRID_HD inline int floor_of(double value) {
  const int truncated{clamped_to_int(value)};
  return truncated > value ? truncated - 1 : truncated;
}

/// Antecedents of every cell for a displacement of (shift_x, shift_y) cells, read from a window that has since moved by
/// (moved_x, moved_y) whole cells.
STEREOGRID_HD inline Antecedents antecedents(double shift_x, double shift_y, int moved_x, int moved_y) {
  const int ix{floor_of(-shift_x)};
  const int iy{floor_of(-shift_y)};
  return {ix + moved_x, iy + moved_y, static_cast<float>(-shift_x - ix), static_cast<float>(-shift_y - iy)};
}

/// The likelihoods of an observed probability p formed with prior ½: (p, 1 − p), tempered, and the odds that p is, as
/// they are. docs/method.md §8.3.
struct Likelihood {
  float occupied;
  float empty;
  float odds{1};
};

/// Table of p to the power of the exponent, for p = i / likelihood_steps.
constexpr int likelihood_steps{4096};

STEREOGRID_HD inline float tempered(const float* table, float p) {
  const float at{p * likelihood_steps};
  const int whole{static_cast<int>(at)};
  const int i{whole < likelihood_steps ? whole : likelihood_steps - 1};
  return between(table[i], table[i + 1], at - static_cast<float>(i));
}

/// 0 and 1 would make a cell deaf to everything that comes later.
STEREOGRID_HD inline Likelihood likelihood_of(const float* table, float observed) {
  const float above{observed < 0.001f ? 0.001f : observed};
  const float p{above > 0.999f ? 0.999f : above};
  return {tempered(table, p), tempered(table, 1 - p), p / (1 - p)};
}

using VelocitySums = LatticeSums<float>;

/// The velocity of what occupies a cell.
struct VelocityEstimate {
  float x;  ///< mean, m/s
  float y;
  float xx;  ///< covariance, m²/s²
  float xy;
  float yy;
};

/// Of the sums over what occupies a cell, up to a factor; nothing: 0.
STEREOGRID_HD inline VelocityEstimate estimate_of(const VelocitySums& sums) {
  const float share{sums.mass > 0 ? 1 / sums.mass : 0.0f};
  const float x{share * sums.x};
  const float y{share * sums.y};
  const float xx{share * sums.xx - x * x};
  const float yy{share * sums.yy - y * y};
  return {x, y, xx > 0 ? xx : 0.0f, share * sums.xy - x * y, yy > 0 ? yy : 0.0f};
}

/// The same in axes turned by the angle whose cosine and sine are given.
STEREOGRID_HD inline VelocityEstimate turned(const VelocityEstimate& v, float c, float s) {
  return {c * v.x + s * v.y, -s * v.x + c * v.y, c * c * v.xx + 2 * c * s * v.xy + s * s * v.yy,
          c * s * (v.yy - v.xx) + (c * c - s * s) * v.xy, s * s * v.xx - 2 * c * s * v.xy + c * c * v.yy};
}

/// Between the four cells around (x, y), in cells from the centre of the first; the border repeats. `at(x, y)`.
template <class At>
STEREOGRID_HD inline float interpolated(const At& at, int width, int height, double x, double y) {
  const auto within = [](int cell, int count) { return cell < 0 ? 0 : (cell < count ? cell : count - 1); };
  const int ix{floor_of(x)};
  const int iy{floor_of(y)};
  const float fx{static_cast<float>(x - ix)};
  const float fy{static_cast<float>(y - iy)};
  const auto value = [&](int cx, int cy) { return at(within(cx, width), within(cy, height)); };
  return (1 - fy) * ((1 - fx) * value(ix, iy) + fx * value(ix + 1, iy)) +
         fy * ((1 - fx) * value(ix, iy + 1) + fx * value(ix + 1, iy + 1));
}

/// P(occupied by something that moves), of what occupies the cell with probability `occupancy`.
STEREOGRID_HD inline float moving_share(float occupancy, float standing) {
  return occupancy > standing ? occupancy - standing : 0.0f;
}

/// Greater than every age of a cell that has been seen.
constexpr float never_s{3e38f};

/// What prediction and update (docs/method.md §8.7) do to the masses that have arrived in a cell:
/// m(k) ← scale·m(k) + born(k).
struct JointUpdate {
  float scale;
  float born_standing;  ///< born(k) of standstill
  float born_moving;    ///< of every other velocity
  float occupancy;      ///< Σ m(k) afterwards
};

/// How the camera sees a cell. docs/method.md §8.3, §8.4.
struct CellView {
  float repeated;  ///< how far the view is that of the step before: 0: another one, 1: the same
  float forgetting;
};

STEREOGRID_HD inline CellView view_of(const FilterStep& step, int x, int y) {
  const float dx{static_cast<float>(x) - step.camera_x};
  const float dy{static_cast<float>(y) - step.camera_y};
  const float ahead{dx * step.ahead_x + dy * step.ahead_y};
  const float left{dy * step.ahead_x - dx * step.ahead_y};
  const float squares{dx * dx + dy * dy};
  const bool is_in_view{ahead > 0 && left <= ahead * step.view_left && -left <= ahead * step.view_right};
  return {squares > step.new_view_squares ? 1 - step.new_view_squares / squares : 0.0f,
          is_in_view ? step.forgetting_in_view : step.forgetting};
}

/// Errors repeat themselves as long as the view is the same: there, what is observed again takes a cell no farther than
/// to its own odds, and what goes against what was known counts in full. docs/method.md §8.3.
STEREOGRID_HD inline float fresh_ratio(float repeated, float predicted, Likelihood likelihood) {
  const float ratio{likelihood.occupied / likelihood.empty};
  const float wanted{likelihood.odds * (1 - predicted) / predicted};
  const float low{ratio < 1 ? ratio : 1.0f};
  const float high{ratio > 1 ? ratio : 1.0f};
  const float capped{wanted < low ? low : (wanted > high ? high : wanted)};
  return ratio + repeated * (capped - ratio);
}

/// `arrived`: Σ m(k) before it; `age_s`: of the cell before the step; `view`: view_of the cell. A cell that nobody
/// has seen stays unknown even where its mass has moved into seen cells. What appears on ground that has just been seen
/// free has come from somewhere: it is more likely to move than what appears out of the unknown.
STEREOGRID_HD inline JointUpdate joint_update(const FilterStep& step, float arrived, float age_s, Likelihood likelihood,
                                              CellView view) {
  const float total{arrived > 1 ? 1.0f : arrived};
  const float lacking{age_s > never_s && total < 0.5f ? 0.5f - total : 0.0f};
  const float kept{1 - view.forgetting};
  const float empty{1 - total - lacking};
  const float predicted{kept * (total + lacking) + view.forgetting * empty};
  const bool is_fresh{view.repeated == 0 || !(predicted > 0)};
  const float occupied{is_fresh ? likelihood.occupied : fresh_ratio(view.repeated, predicted, likelihood)};
  const float evidence{occupied * predicted + (is_fresh ? likelihood.empty : 1.0f) * (1 - predicted)};
  const float gain{occupied / evidence};
  const float unseen{gain * kept * lacking};
  const float appeared{gain * view.forgetting * empty};
  const bool was_seen{age_s == 0};
  const float standing{was_seen ? step.appearing_static : step.prior_static};
  const float moving{was_seen ? step.appearing_moving : step.prior_moving};
  return {gain * kept * (arrived > 1 ? 1 / arrived : 1.0f), unseen * step.prior_static + appeared * standing,
          unseen * step.prior_moving + appeared * moving, gain * predicted};
}

/// The same for the sums over a cell's masses. New mass has mean velocity 0.
STEREOGRID_HD inline VelocitySums updated(const FilterStep& step, const JointUpdate& update,
                                          const VelocitySums& arrived) {
  const float spread{update.born_moving * step.lattice_squares};
  return {update.occupancy,          update.scale * arrived.x,
          update.scale * arrived.y,  update.scale * arrived.xx + spread,
          update.scale * arrived.xy, update.scale * arrived.yy + spread};
}

/// What the filter says about a cell after a step.
struct FilteredCell {
  float occupancy;
  float standing;
  VelocitySums sums;
};

/// P(still or newly occupied) before the update.
STEREOGRID_HD inline float still_occupied(const FilterStep& step, float occupancy) {
  return (1 - step.forgetting) * occupancy + step.forgetting * (1 - occupancy);
}

}  // namespace stereogrid
