// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <cmath>
#include <limits>

#include "clamped_to_int.hpp"
#include "filter/filter.hpp"

namespace stereogrid {
namespace {

// The window's movement since the step before, in whole cells.
int moved(double now_m, double before_m, double cell_size_m) {
  return clamped_to_int(std::round((now_m - before_m) / cell_size_m));
}

struct Step {
  FilterStep constants;
  const FilterInput& input;
  const FilterState& before;
  int moved_x;
  int moved_y;
  std::span<const CellBox> moving{};  // joint: of each block before

  [[nodiscard]] bool inside(int x, int y) const {
    return x >= 0 && x < before.occupancy.width() && y >= 0 && y < before.occupancy.height();
  }
  // P(occupied, v_k) (joint) or P(v_k) (tay2008) before the noise
  [[nodiscard]] float mass(std::size_t k, int x, int y) const {
    if (is_tay()) return before.velocity[k](x, y);
    const BlockLayout& layout{before.blocks.layout()};
    const bool moves{!moving[static_cast<std::size_t>(layout.block_of(x, y))].is_empty()};
    const float* const masses{moves ? before.blocks.masses_at(x, y) : nullptr};
    return masses != nullptr ? masses[k * block_cells]
                             : even_mass(constants.each_moving, before.occupancy(x, y), standing(x, y));
  }
  [[nodiscard]] bool is_tay() const { return input.config.model == FilterModel::tay2008; }
  [[nodiscard]] std::size_t standstill() const { return static_cast<std::size_t>(constants.standstill()); }
  [[nodiscard]] float standing(int x, int y) const {
    return is_tay() ? before.velocity[standstill()](x, y) : before.standing(x, y);
  }
  // mass of velocity k after the noise; `all`: mass of all velocities
  [[nodiscard]] float disturbed_at(std::size_t k, int x, int y, float all) const {
    const float stands{standing(x, y)};
    if (k == standstill()) return disturbed_standing(constants, all, stands);
    return disturbed(constants.kept_moving, mass(k, x, y), gained_by_moving(constants, all, stands));
  }
  // of each moving velocity of a cell, were they alike
  [[nodiscard]] float even_at(int x, int y) const {
    if (!inside(x, y)) return even_outside(constants);
    const float all{before.occupancy(x, y)};
    return disturbed(constants.kept_moving, even_mass(constants.each_moving, all, standing(x, y)),
                     gained_by_moving(constants, all, standing(x, y)));
  }
  // joint: nothing has been known of the cell
  [[nodiscard]] bool was_unseen(int x, int y) const {
    if (!is_known(x, y)) return true;
    return before.is_as_unseen(constants, x + moved_x, y + moved_y);
  }
  // the cell has been in the window before
  [[nodiscard]] bool is_known(int x, int y) const { return inside(x + moved_x, y + moved_y); }
  [[nodiscard]] float age_before(int x, int y) const {
    return is_known(x, y) ? before.age_s(x + moved_x, y + moved_y) : std::numeric_limits<float>::infinity();
  }
  [[nodiscard]] Antecedents antecedents_of(std::size_t k) const {
    const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
    const Point2 v{input.tables.lattice[k]};
    return antecedents(v.x * cells_per_mps, v.y * cells_per_mps, moved_x, moved_y);
  }
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

// `value(x, y)` between the four antecedents; it must also answer for places outside.
template <class Value>
float gathered(const Antecedents& from, int x, int y, const Value& value) {
  const int ax{x + from.ix};
  const int ay{y + from.iy};
  return between(between(value(ax, ay), value(ax + 1, ay), from.fx),
                 between(value(ax, ay + 1), value(ax + 1, ay + 1), from.fx), from.fy);
}

// docs/method.md §8.7; `mass` becomes P(occupied, v_k)
FilteredCell lattice_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& mass) {
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
  const JointUpdate update{
      joint_update(constants, arrived.mass, step.age_before(x, y), likelihood, view_of(constants, x, y))};
  for (std::size_t k{0}; k < mass.size(); ++k) {
    const bool stands{static_cast<int>(k) == constants.standstill()};
    mass[k] = update.scale * mass[k] + (stands ? update.born_standing : update.born_moving);
  }
  return {update.occupancy, mass[mass.size() / 2], updated(constants, update, arrived)};
}

// The same of a cell without masses of its own.
FilteredCell even_cell(const Step& step, int x, int y, float observed, Likelihood likelihood) {
  const FilterStep& constants{step.constants};
  const auto side = static_cast<std::size_t>(constants.side);
  const auto spread_along_x = [&](int ax, int ay) {
    float sum{0};
    for (std::size_t i{0}; i < side; ++i) {
      const Antecedents from{step.antecedents_of(i)};
      sum += between(step.even_at(ax + from.ix, ay), step.even_at(ax + from.ix + 1, ay), from.fx);
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
    const int ax{x + step.moved_x};
    const int ay{y + step.moved_y};
    arrived = {step.disturbed_at(step.standstill(), ax, ay, step.before.occupancy(ax, ay)),
               even_arrived(constants.each_moving, spread, step.even_at(ax, ay))};
  }
  return updated_evenly(constants, arrived.standing, arrived.each, step.age_before(x, y),
                        observed == 0.5f && step.was_unseen(x, y), likelihood, view_of(constants, x, y));
}

// docs/method.md §8.6; `velocity` becomes P(v_k), `occupied` P(occupied, v_k) up to a factor
FilteredCell tay_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& velocity,
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

}  // namespace

namespace {

FilteredCell cell_of(const Step& step, int x, int y, float observed, std::vector<float>& masses, FilterState& after) {
  const Likelihood likelihood{likelihood_of(step.input.tables.likelihood.data(), observed)};
  if (step.is_tay()) {
    std::vector<float> occupied(masses.size());
    const FilteredCell cell{tay_cell(step, x, y, likelihood, masses, occupied)};
    for (std::size_t k{0}; k < masses.size(); ++k) after.velocity[k](x, y) = masses[k];
    return cell;
  }
  float* const kept{after.blocks.masses_at(x, y)};
  const FilteredCell cell{kept != nullptr ? lattice_cell(step, x, y, likelihood, masses)
                                          : even_cell(step, x, y, observed, likelihood)};
  for (std::size_t k{0}; k < masses.size() && kept != nullptr; ++k) kept[k * block_cells] = masses[k];
  after.standing(x, y) = cell.standing;
  return cell;
}

// Of each block of the window before; none: tay2008.
std::vector<CellBox> moving_cells_of(const FilterState& before, const FilterStep& step, Scroll scroll) {
  std::vector<CellBox> moving(before.space.moving.size());
  for (std::size_t i{0}; i < moving.size(); ++i) moving[i] = before.moving_cells(step, scroll, static_cast<int>(i));
  return moving;
}

}  // namespace

void filter(Reference& /*reference*/, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  const FilterStep constants{step_of(input)};
  const Scroll scroll{moved(input.geometry.x_min_m, before.geometry.x_min_m, input.geometry.cell_size_m),
                      moved(input.geometry.y_min_m, before.geometry.y_min_m, input.geometry.cell_size_m)};
  const std::vector<CellBox> moving{moving_cells_of(before, constants, scroll)};
  const Step step{constants, input, before, scroll.x, scroll.y, moving};
  after.blocks.begin(constants, scroll, moving);
  after.forget_kinds();
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
                      WeighingSpace& /*space*/, FilterState& state, GridLayers& layers) {
  weigh_velocities(reference, evidence, tables, state, layers);
}

void weigh_velocities(Reference& /*reference*/, std::span<const VelocityEvidence> evidence, const FilterTables& tables,
                      FilterState& state, GridLayers& layers) {
  CellWeigher weigher{tables, state, layers};
  std::vector<VelocityEvidence> starting;
  for (const VelocityEvidence& one : evidence) {
    if (!weigher.weigh(one, true)) starting.push_back(one);
  }
  begin_wanted_blocks(tables, state);
  for (const VelocityEvidence& one : starting) weigher.weigh(one, false);
}

}  // namespace stereogrid
