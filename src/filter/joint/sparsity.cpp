// SPDX-License-Identifier: Apache-2.0

#include "filter/reference_step.hpp"

namespace stereogrid {
namespace {

// Mass of each moving velocity of a cell after the noise, spread evenly.
float even_at(const ReferenceStep& step, int x, int y) {
  const FilterStep& constants{step.constants};
  if (!step.inside(x, y)) return even_outside(constants);
  const float all{step.before.occupancy(x, y)};
  const float stands{step.standing(x, y)};
  return disturbed(constants.kept_moving, even_mass(constants.each_moving, all, stands),
                   gained_by_moving(constants, all, stands));
}

bool was_unseen(const ReferenceStep& step, int x, int y) {
  if (!step.is_known(x, y)) return true;
  return step.before.is_as_unseen(step.constants, x + step.moved.x, y + step.moved.y);
}

}  // namespace

float sparse_mass(const FilterStep& constants, const FilterState& before, std::span<const CellBox> moving,
                  std::size_t k, int x, int y) {
  const BlockLayout& layout{before.blocks.layout()};
  const bool moves{!moving[static_cast<std::size_t>(layout.block_of(x, y))].is_empty()};
  const float* const masses{moves ? before.blocks.masses_at(x, y) : nullptr};
  return masses != nullptr ? masses[k * block_cells]
                           : even_mass(constants.each_moving, before.occupancy(x, y), before.standing(x, y));
}

std::vector<CellBox> moving_cells_of(const FilterState& before, const FilterStep& step, Scroll scroll) {
  std::vector<CellBox> moving(before.space.moving.size());
  for (std::size_t i{0}; i < moving.size(); ++i) moving[i] = before.moving_cells(step, scroll, static_cast<int>(i));
  return moving;
}

FilteredCell even_cell(const ReferenceStep& step, int x, int y, float observed, Likelihood likelihood) {
  const FilterStep& constants{step.constants};
  const auto side = static_cast<std::size_t>(constants.side);
  const auto spread_along_x = [&](int ax, int ay) {
    float sum{0};
    for (std::size_t i{0}; i < side; ++i) {
      const Antecedents from{step.antecedents_of(i)};
      sum += between(even_at(step, ax + from.ix, ay), even_at(step, ax + from.ix + 1, ay), from.fx);
    }
    return sum;
  };
  EvenArrived arrived{new_to_the_window(constants)};
  if (step.is_known(x, y)) {
    float spread{0};
    for (std::size_t j{0}; j < side; ++j) {
      const Antecedents from{step.antecedents_of(j * side)};
      spread += between(spread_along_x(x, y + from.iy), spread_along_x(x, y + from.iy + 1), from.fy);
    }
    const int ax{x + step.moved.x};
    const int ay{y + step.moved.y};
    arrived = {step.disturbed_at(step.standstill(), ax, ay, step.before.occupancy(ax, ay)),
               even_arrived(constants.each_moving, spread, even_at(step, ax, ay))};
  }
  return updated_evenly(constants, arrived.standing, arrived.each, step.age_before(x, y),
                        observed == 0.5f && was_unseen(step, x, y), likelihood, view_of(constants, x, y));
}

}  // namespace stereogrid
