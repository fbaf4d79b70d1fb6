// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "clamped_to_int.hpp"
#include "fusion/model.hpp"
#include "host_device.hpp"
#include "numbers.hpp"

namespace stereogrid {

#include "filter/lattice_formulas.hpp"

/// Thresholds of a moving cell: moving mass, and its share of the occupied mass.
struct MovingFrom {
  float mass;
  float part;
};

/// Place and angle of view of a camera in a filter step.
struct ViewOfStep {
  float camera_x;  ///< column and row of the cell in which the camera is
  float camera_y;
  float ahead_x;  ///< viewing direction, of length 1
  float ahead_y;
  float left;      ///< cells to the left, for each cell ahead, that it sees; to the right
  float right;     ///< both negative: nothing is known of the camera
  float nearest;   ///< cells ahead from which on it sees the least height of obstacles
  float baseline;  ///< cells to the right camera
};

/// Constants of one filter step.
struct FilterStep {
  int side;                ///< the lattice has side × side velocities, y-major; odd: the middle one is standstill
  float decay;             ///< eps of docs/method.md §8.4, from the time constant and the time step
  float kept_moving;       ///< share of a moving velocity's mass that keeps it: 1 − mu
  float kept_standing;     ///< share of the static mass that stays static
  float spread;            ///< share of all moving mass that each moving velocity gains
  float start;             ///< share of the standing mass that each moving velocity gains
  float stop;              ///< share of the moving mass that comes to stand
  float border_occupancy;  ///< occupancy of cells outside the window
  float prior_static;      ///< prior of standstill for new mass
  float prior_moving;      ///< prior of every other velocity for new mass
  float appearing_static;  ///< prior of standstill for mass that appears on ground seen free in the frame before
  float appearing_moving;  ///< prior of every other velocity for that
  float lattice_squares;   ///< Σ v_x² over the lattice, m²/s²
  float decay_in_view;     ///< likewise of cells within a camera's angle of view
  ViewOfStep views[cameras_max];
  int other_views;          ///< number of views after the first, around whose camera the squared radii are
  float new_view_squares;   ///< squared radius around the camera, in cells, within which the view has changed
  float appearing_squares;  ///< likewise: within it, appearing mass has moved there; infinite: everywhere
  float sharp_squares;      ///< likewise: beyond it, cells in view decay faster; infinite: nowhere
  float moving_squares;     ///< likewise: there, blocks can have masses
  float moving_velocities;  ///< velocities of the lattice except standstill
  float each_moving;        ///< one of them by their number; 0: there are none
  MovingFrom moving_from;   ///< from which on a cell moves
  int reach;                ///< cells that the fastest velocity goes along an axis

  STEREOGRID_HD int velocities() const { return side * side; }
  STEREOGRID_HD int standstill() const { return side * side / 2; }
};

STEREOGRID_HD inline float prior_of(const FilterStep& step, int k) {
  return k == step.standstill() ? step.prior_static : step.prior_moving;
}

/// Source cells of a cell's mass for a displacement that is no whole number of cells: from[i] between the cells ix and
/// ix + 1 further along x, likewise along y.
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

/// Size of the table of p to the power of the exponent, for p = i / likelihood_steps.
constexpr int likelihood_steps{4096};

#include "filter/cell_formulas.hpp"

using Likelihood = CellLikelihood<float>;
using CellView = ViewOfCell<float>;
using JointUpdate = UpdateOfCell<float>;
using VelocityEstimate = EstimateOfVelocity<float>;
using FilteredCell = CellAfter<float>;

STEREOGRID_HD inline float tempered(const float* table, float p) {
  return tempered([table](int i) { return table[i]; }, p);
}
STEREOGRID_HD inline Likelihood likelihood_of(const float* table, float observed) {
  return likelihood_of_cell([table](int i) { return table[i]; }, observed);
}
STEREOGRID_HD inline CellView view_of(const FilterStep& step, int x, int y) {
  return view_of_cell(step, static_cast<float>(x), static_cast<float>(y));
}

using VelocitySums = LatticeSums<float>;

/// P(still or newly occupied) before the update.
STEREOGRID_HD inline float still_occupied(const FilterStep& step, float occupancy) {
  return (1 - step.decay) * occupancy + step.decay * (1 - occupancy);
}

}  // namespace stereogrid
