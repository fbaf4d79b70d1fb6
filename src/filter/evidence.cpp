// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/filter.hpp"

namespace stereogrid {

bool CellWeigher::weigh(const VelocityEvidence& one, bool may_start) {
  const int x{one.cell % state_.occupancy.width()};
  const int y{one.cell / state_.occupancy.width()};
  const float occupancy{state_.occupancy(x, y)};
  const float* const axis_mps{tables_.axis_mps.data()};
  const int side{static_cast<int>(tables_.axis_mps.size())};
  float* const masses{state_.blocks.masses_at(x, y)};
  WeighedCell cell{};
  if (masses != nullptr) {
    const auto mass = [masses](int k) -> float& { return masses[static_cast<std::ptrdiff_t>(k) * block_cells]; };
    cell = stereogrid::weigh(one, axis_mps, side, mass, [&](int k, float m) { mass(k) = m; });
  } else {
    const float each{even_mass(tables_.each_moving, occupancy, state_.standing(x, y))};
    cell = weigh_evenly(one, axis_mps, side, each, state_.standing(x, y));
    if (may_start && is_moving(tables_.moving_from, occupancy, cell.standing)) {
      state_.blocks.want(state_.blocks.layout().block_of(x, y));
      return false;
    }
  }
  state_.standing(x, y) = cell.standing;
  layers_.moving(x, y) = moving_share(occupancy, cell.standing);
  write_velocity(estimate_of(cell.sums), x, y, layers_);
  return true;
}

void begin_wanted_blocks(const FilterTables& tables, FilterState& state) {
  const std::size_t velocities{tables.lattice.size()};
  for (const int block : state.blocks.begin_wanted()) {
    const CellBox cells{state.blocks.layout().cells_of(block)};
    for (int y{cells.y_first}; y <= cells.y_last; ++y) {
      for (int x{cells.x_first}; x <= cells.x_last; ++x) {
        const float standing{state.standing(x, y)};
        const float each{even_mass(tables.each_moving, state.occupancy(x, y), standing)};
        float* const masses{state.blocks.masses_at(x, y)};
        for (std::size_t k{0}; k < velocities; ++k) masses[k * block_cells] = k == velocities / 2 ? standing : each;
      }
    }
  }
}

}  // namespace stereogrid
