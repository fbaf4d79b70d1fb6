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

  [[nodiscard]] bool inside(int x, int y) const {
    return x >= 0 && x < before.occupancy.width() && y >= 0 && y < before.occupancy.height();
  }
  // mass of velocity k after the noise; `all`: mass of all velocities
  [[nodiscard]] float disturbed_at(std::size_t k, int x, int y, float all) const {
    const std::size_t standstill{before.velocity.size() / 2};
    const float standing{before.velocity[standstill](x, y)};
    if (k == standstill) return disturbed_standing(constants, all, standing);
    return disturbed(constants.kept_moving, before.velocity[k](x, y), gained_by_moving(constants, all, standing));
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

// What the filter says about a cell after the step.
struct Cell {
  VelocitySums sums;  // of the occupied mass, up to a factor
  float standing;     // likewise
  float occupancy;
};

// docs/method.md §8.7; `mass` becomes P(occupied, v_k)
Cell joint_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& mass) {
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
  return {updated(constants, update, arrived), mass[mass.size() / 2], update.occupancy};
}

// docs/method.md §8.6; `velocity` becomes P(v_k), `occupied` P(occupied, v_k) up to a factor
Cell tay_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& velocity,
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
  return {sums, scale * occupied[occupied.size() / 2], scale * sums.mass};
}

}  // namespace

void filter(Reference& /*reference*/, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  const Step step{step_of(input), input, before,
                  moved(input.geometry.x_min_m, before.geometry.x_min_m, input.geometry.cell_size_m),
                  moved(input.geometry.y_min_m, before.geometry.y_min_m, input.geometry.cell_size_m)};
  const bool joint{input.config.model == FilterModel::joint};
  std::vector<float> state(input.tables.lattice.size());
  std::vector<float> occupied(state.size());
  after.geometry = layers.geometry = input.geometry;
  for (int y{0}; y < observed.height; ++y) {
    for (int x{0}; x < observed.width; ++x) {
      const Likelihood likelihood{likelihood_of(input.tables.likelihood.data(), observed(x, y))};
      const Cell cell{joint ? joint_cell(step, x, y, likelihood, state)
                            : tay_cell(step, x, y, likelihood, state, occupied)};
      for (std::size_t k{0}; k < state.size(); ++k) after.velocity[k](x, y) = state[k];
      const bool seen{is_known(observed(x, y))};
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
  const int cells{layers.occupancy.width()};
  for (const VelocityEvidence& one : evidence) {
    const int x{one.cell % cells};
    const int y{one.cell / cells};
    const auto mass = [&](int k) -> float& { return state.velocity[static_cast<std::size_t>(k)](x, y); };
    const WeighedCell cell{weigh(one, tables.axis_mps.data(), static_cast<int>(tables.axis_mps.size()), mass)};
    layers.moving(x, y) = moving_share(layers.occupancy(x, y), cell.standing);
    write_velocity(estimate_of(cell.sums), x, y, layers);
  }
}

}  // namespace stereogrid
