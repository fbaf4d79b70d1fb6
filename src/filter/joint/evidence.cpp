// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "filter/filter.hpp"

namespace stereogrid {

bool CellWeigher::weigh(const VelocityEvidence& one, bool may_start) {
  const int x{one.cell % state_.occupancy.width()};
  const int y{one.cell / state_.occupancy.width()};
  if (is_ignored(one, state_.age_s(x, y))) return true;
  start_motion(tables_, one, state_);
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
  state_.invalidate_kind(x, y);
  state_.standing(x, y) = cell.standing;
  layers_.moving(x, y) = moving_share(occupancy, cell.standing);
  write_velocity(refined(one, axis_mps, side, cell), x, y, layers_);
  return true;
}

void start_motion(const FilterTables& tables, const VelocityEvidence& one, FilterState& state) {
  const int x{one.cell % state.occupancy.width()};
  const int y{one.cell / state.occupancy.width()};
  float& standing{state.standing(x, y)};
  const float before{standing};
  standing = standing_before(one, state.occupancy(x, y), before);
  const float started{before - standing};
  float* masses{state.blocks.masses_at(x, y)};
  if (started == 0 || masses == nullptr) return;
  const std::size_t velocities{tables.lattice.size()};
  const float each{started * tables.each_moving};
  for (std::size_t k{0}; k < velocities; ++k, masses += block_cells) *masses += k == velocities / 2 ? -started : each;
}

namespace {

// Fills a new block with each cell's mass, spread evenly.
void fill_begun_block(const FilterTables& tables, FilterState& state, int block) {
  const CellBox cells{state.blocks.layout().cells_of(block)};
  float standing[block_cells]{};
  float each[block_cells]{};
  for (int y{cells.y_first}; y <= cells.y_last; ++y) {
    for (int x{cells.x_first}; x <= cells.x_last; ++x) {
      const int i{(y - cells.y_first) * block_columns + x - cells.x_first};
      standing[i] = state.standing(x, y);
      each[i] = even_mass(tables.each_moving, state.occupancy(x, y), standing[i]);
    }
  }
  float* masses{state.blocks.masses(state.blocks.slot(block))};
  const std::size_t velocities{tables.lattice.size()};
  for (std::size_t k{0}; k < velocities; ++k, masses += block_cells) {
    std::copy_n(k == velocities / 2 ? standing : each, block_cells, masses);
  }
}

}  // namespace

void allocate_marked_blocks(const FilterTables& tables, FilterState& state) {
  for (const int block : state.blocks.allocate_marked()) fill_begun_block(tables, state, block);
}

}  // namespace stereogrid
