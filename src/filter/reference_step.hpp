// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "filter/filter.hpp"

namespace stereogrid {

struct ReferenceStep;

// Sparsity of the joint filter. The literal form (joint_cell) has a mass for every cell and velocity. Two rules leave
// most of them out; a test bounds the difference to the literal form:
//  1. Only blocks of which a cell moves keep masses. Elsewhere the moving mass is spread evenly over the moving
//  velocities.
//  2. A cell of which nothing was ever observed, and into which nothing moves, stays as it is.

/// P(occupied, v_k) of a cell before the step: kept, or spread evenly. `moving`: cells of each block that move.
[[nodiscard]] float sparse_mass(const FilterStep& constants, const FilterState& before, std::span<const CellBox> moving,
                                std::size_t k, int x, int y);

/// Cells that move, of each block of the window before. Empty for tay2008.
[[nodiscard]] std::vector<CellBox> moving_cells_of(const FilterState& before, const FilterStep& step, Scroll scroll);

/// Rule 1 for a cell of a block without masses: the sum of joint_cell over all moving velocities at once.
/// docs/method.md §8.7. `observed`: P(T_X) of the cell, 0.5 = unobserved.
[[nodiscard]] FilteredCell even_cell(const ReferenceStep& step, int x, int y, float observed, Likelihood likelihood);

/// A step of the filter as the plain loops compute it: what each cell's equations read.
struct ReferenceStep {
  FilterStep constants;
  const FilterInput& input;
  const FilterState& before;
  Scroll moved;                      ///< the window, since the step before
  std::vector<CellBox> moving = {};  ///< joint: cells of each block before that move

  [[nodiscard]] bool is_tay() const { return input.config.model == FilterModel::tay2008; }
  [[nodiscard]] std::size_t standstill() const { return static_cast<std::size_t>(constants.standstill()); }
  [[nodiscard]] bool inside(int x, int y) const {
    return x >= 0 && x < before.occupancy.width() && y >= 0 && y < before.occupancy.height();
  }
  /// The cell was in the window before.
  [[nodiscard]] bool is_known(int x, int y) const { return inside(x + moved.x, y + moved.y); }

  /// P(occupied, v_k) (joint) or P(v_k) (tay2008) before the noise.
  [[nodiscard]] float mass(std::size_t k, int x, int y) const {
    return is_tay() ? before.velocity[k](x, y) : sparse_mass(constants, before, moving, k, x, y);
  }
  [[nodiscard]] float standing(int x, int y) const {
    return is_tay() ? before.velocity[standstill()](x, y) : before.standing(x, y);
  }
  /// Mass of velocity k after the noise. `all`: mass of all velocities.
  [[nodiscard]] float disturbed_at(std::size_t k, int x, int y, float all) const {
    const float stands{standing(x, y)};
    if (k == standstill()) return disturbed_standing(constants, all, stands);
    return disturbed(constants.kept_moving, mass(k, x, y), gained_by_moving(constants, all, stands));
  }
  [[nodiscard]] float age_before(int x, int y) const {
    return is_known(x, y) ? before.age_s(x + moved.x, y + moved.y) : std::numeric_limits<float>::infinity();
  }
  [[nodiscard]] Antecedents antecedents_of(std::size_t k) const {
    const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
    const Point2 v{input.tables.lattice[k]};
    return antecedents(v.x * cells_per_mps, v.y * cells_per_mps, moved.x, moved.y);
  }
  /// Mass, momentum and squares of the lattice's masses.
  [[nodiscard]] VelocitySums sums_of(const std::vector<float>& masses) const {
    VelocitySums sums;
    std::size_t k{0};
    for (const float vy : input.tables.axis_mps) {
      LatticeRowSums<float> row;
      for (const float vx : input.tables.axis_mps) row.add(vx, masses[k++]);
      sums.add(vy, row);
    }
    return sums;
  }
};

/// `value(x, y)` interpolated between the four antecedents; it is also called for cells outside the window.
template <class Value>
float gathered(const Antecedents& from, int x, int y, const Value& value) {
  const int ax{x + from.ix};
  const int ay{y + from.iy};
  return between(between(value(ax, ay), value(ax + 1, ay), from.fx),
                 between(value(ax, ay + 1), value(ax + 1, ay + 1), from.fx), from.fy);
}

}  // namespace stereogrid
