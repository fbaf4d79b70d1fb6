// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include "filter/filter.hpp"
#include "filter/reference_step.hpp"

namespace stereogrid {
namespace {

// Joint form, docs/method.md §8.7. `mass` becomes P(occupied, v_k).
FilteredCell joint_cell(const ReferenceStep& step, int x, int y, Likelihood likelihood, std::vector<float>& mass) {
  const FilterStep& constants{step.constants};
  for (std::size_t k{0}; k < mass.size(); ++k) {
    const float prior{prior_of(constants, static_cast<int>(k))};
    if (!step.is_known(x, y)) {
      mass[k] = 0.5f * prior;
    } else {
      mass[k] = gathered(step.antecedents_of(k), x, y, [&](int ax, int ay) {
        if (!step.inside(ax, ay)) return constants.border_occupancy * prior;
        return step.disturbed_at(k, ax, ay, step.before.occupancy(ax, ay));
      });
    }
  }
  const VelocitySums arrived{step.sums_of(mass)};
  const JointUpdate update{joint_update(constants, arrived.mass, mass[mass.size() / 2], step.age_before(x, y),
                                        likelihood, view_of(constants, x, y))};
  for (std::size_t k{0}; k < mass.size(); ++k) {
    const bool stands{static_cast<int>(k) == constants.standstill()};
    mass[k] = update.scale * mass[k] + (stands ? update.birth_static : update.birth_moving);
  }
  return {update.occupancy, mass[mass.size() / 2], updated(constants, update, arrived)};
}

// Form of 2008, docs/method.md §8.6. `velocity` becomes P(v_k), `occupied` P(occupied, v_k) up to a factor.
FilteredCell tay_cell(const ReferenceStep& step, int x, int y, Likelihood likelihood, std::vector<float>& velocity,
                      std::vector<float>& occupied) {
  const FilterStep& constants{step.constants};
  for (std::size_t k{0}; k < velocity.size(); ++k) {
    const Antecedents from{step.antecedents_of(k)};
    const float prior{prior_of(constants, static_cast<int>(k))};
    const auto moving = [&](int ax, int ay) { return step.inside(ax, ay) ? step.disturbed_at(k, ax, ay, 1) : prior; };
    const auto occupied_before = [&](int ax, int ay) {
      return still_occupied(constants, step.inside(ax, ay) ? step.before.occupancy(ax, ay) : 0.5f);
    };
    const float all{gathered(from, x, y, moving)};
    const float still_there{
        gathered(from, x, y, [&](int ax, int ay) { return moving(ax, ay) * occupied_before(ax, ay); })};
    const TayUpdate<float> update{tay_update(all, still_there, likelihood.occupied, likelihood.empty)};
    occupied[k] = update.occupied;
    velocity[k] = update.all;
  }
  const float scale{1 / step.sums_of(velocity).mass};
  for (float& v : velocity) v = scale * v;
  const VelocitySums sums{step.sums_of(occupied)};
  return {scale * sums.mass, scale * occupied[occupied.size() / 2], sums};
}

FilteredCell cell_of(const ReferenceStep& step, int x, int y, float observed, std::vector<float>& masses,
                     FilterState& after) {
  const Likelihood likelihood{likelihood_of(step.input.tables.likelihood.data(), observed)};
  if (step.is_tay()) {
    std::vector<float> occupied(masses.size());
    const FilteredCell cell{tay_cell(step, x, y, likelihood, masses, occupied)};
    for (std::size_t k{0}; k < masses.size(); ++k) after.velocity[k](x, y) = masses[k];
    return cell;
  }
  float* const kept{after.blocks.masses_at(x, y)};
  const FilteredCell cell{kept != nullptr ? joint_cell(step, x, y, likelihood, masses)
                                          : even_cell(step, x, y, observed, likelihood)};
  for (std::size_t k{0}; k < masses.size() && kept != nullptr; ++k) kept[k * block_cells] = masses[k];
  after.standing(x, y) = cell.standing;
  return cell;
}

}  // namespace

void filter(Reference& /*reference*/, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  const FilterStep constants{step_of(input)};
  const Scroll scroll{scroll_between(before.geometry, input.geometry)};
  const ReferenceStep step{constants, input, before, scroll, moving_cells_of(before, constants, scroll)};
  after.blocks.begin(constants, scroll, step.moving);
  after.invalidate_kinds();
  std::vector<float> masses(input.tables.lattice.size());
  after.geometry = layers.geometry = input.geometry;
  for (int y{0}; y < observed.height; ++y) {
    for (int x{0}; x < observed.width; ++x) {
      const bool seen{is_known(observed(x, y))};
      const FilteredCell cell{cell_of(step, x, y, observed(x, y), masses, after)};
      after.occupancy(x, y) = layers.occupancy(x, y) = cell.occupancy;
      after.age_s(x, y) = layers.age_s(x, y) = seen ? 0.0f : step.age_before(x, y) + static_cast<float>(input.dt_s);
      layers.moving(x, y) = moving_share(cell.occupancy, cell.standing);
      write_velocity(estimate_of(cell.sums), x, y, layers);
    }
  }
}

void weigh_velocities(Reference& reference, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      WeighingWorkspace& /*space*/, FilterState& state, GridLayers& layers) {
  weigh_velocities(reference, evidence, tables, state, layers);
}

void weigh_velocities(Reference& /*reference*/, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      FilterState& state, GridLayers& layers) {
  CellWeigher weigher{tables, state, layers};
  std::vector<VelocityEvidence> starting;
  for (const VelocityEvidence& one : evidence) {
    if (!weigher.weigh(one, true)) starting.push_back(one);
  }
  allocate_marked_blocks(tables, state);
  for (const VelocityEvidence& one : starting) weigher.weigh(one, false);
}

}  // namespace stereogrid
