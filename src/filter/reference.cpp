// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <cmath>
#include <limits>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

// The window's movement since the step before, in whole cells.
int moved(double now_m, double before_m, double cell_size_m) {
  return static_cast<int>(std::lround((now_m - before_m) / cell_size_m));
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
    return k == standstill ? disturbed_standing(constants, before.velocity[k](x, y), all)
                           : disturbed(constants, before.velocity[k](x, y), all, before.velocity[standstill](x, y));
  }
  // the cell has been in the window before
  [[nodiscard]] bool is_known(int x, int y) const { return inside(x + moved_x, y + moved_y); }
  [[nodiscard]] float age_before(int x, int y) const {
    return is_known(x, y) ? before.age_s(x + moved_x, y + moved_y) : std::numeric_limits<float>::infinity();
  }
  [[nodiscard]] Antecedents antecedents_of(std::size_t k) const {
    const double cells_per_mps{input.dt_s / input.geometry.cell_size_m};
    return antecedents(input.lattice[k].x * cells_per_mps, input.lattice[k].y * cells_per_mps, moved_x, moved_y);
  }
};

// Sum over the four antecedents of `value(x, y)`, which must also answer for places outside.
template <class Value>
float gathered(const Antecedents& from, int x, int y, const Value& value) {
  float sum{from.w00 * value(x + from.ix, y + from.iy)};
  sum += from.w10 * value(x + from.ix + 1, y + from.iy);
  sum += from.w01 * value(x + from.ix, y + from.iy + 1);
  sum += from.w11 * value(x + from.ix + 1, y + from.iy + 1);
  return sum;
}

// method §2.6, one cell
float joint_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& mass) {
  const FilterStep& constants{step.constants};
  float sum{0};
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
    sum += mass[k];
  }
  const float scale{sum > 1 ? 1 / sum : 1.0f};
  const float total{sum > 1 ? 1.0f : sum};
  // a cell that nobody has seen stays unknown even where its mass has moved into seen cells
  const float lacking{std::isinf(step.age_before(x, y)) && total < 0.5f ? 0.5f - total : 0.0f};
  const float born{constants.forgetting * (1 - total - lacking)};
  float predicted{0};
  for (std::size_t k{0}; k < mass.size(); ++k) {
    const float prior{prior_of(constants, static_cast<int>(k))};
    mass[k] = (1 - constants.forgetting) * (mass[k] * scale + lacking * prior) + born * prior;
    predicted += mass[k];
  }
  const float evidence{likelihood.occupied * predicted + likelihood.empty * (1 - predicted)};
  for (float& m : mass) m = likelihood.occupied * m / evidence;
  return likelihood.occupied * predicted / evidence;
}

// method §2.3, one cell; `velocity` becomes P(v_k), `occupied` P(occupied, v_k)
float tay_cell(const Step& step, int x, int y, Likelihood likelihood, std::vector<float>& velocity,
               std::vector<float>& occupied) {
  const FilterStep& constants{step.constants};
  float evidence{0};
  float total{0};
  for (std::size_t k{0}; k < velocity.size(); ++k) {
    const Antecedents from{step.antecedents_of(k)};
    const float prior{prior_of(constants, static_cast<int>(k))};
    const auto moving = [&](int ax, int ay) { return step.inside(ax, ay) ? step.disturbed_at(k, ax, ay, 1) : prior; };
    const auto occupied_before = [&](int ax, int ay) {
      const float o{step.inside(ax, ay) ? step.before.occupancy(ax, ay) : 0.5f};
      return (1 - constants.forgetting) * o + constants.forgetting * (1 - o);
    };
    const float alpha_all{gathered(from, x, y, moving)};
    const float alpha_occupied{
        gathered(from, x, y, [&](int ax, int ay) { return moving(ax, ay) * occupied_before(ax, ay); })};
    occupied[k] = likelihood.occupied * alpha_occupied;
    velocity[k] = occupied[k] + likelihood.empty * (alpha_all - alpha_occupied);
    evidence += velocity[k];
    total += occupied[k];
  }
  for (float& v : velocity) v = v / evidence;
  for (float& o : occupied) o = o / evidence;
  return total / evidence;
}

}  // namespace

void filter(Reference& reference, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers) {
  if (input.config.model == FilterModel::particles) {
    return filter_particles(reference, input, observed, before, after, layers);
  }
  const Step step{step_of(input), input, before,
                  moved(input.geometry.x_min_m, before.geometry.x_min_m, input.geometry.cell_size_m),
                  moved(input.geometry.y_min_m, before.geometry.y_min_m, input.geometry.cell_size_m)};
  const bool joint{input.config.model == FilterModel::joint};
  std::vector<float> state(input.lattice.size());
  std::vector<float> occupied(input.lattice.size());
  after.geometry = layers.geometry = input.geometry;
  for (int y{0}; y < observed.height; ++y) {
    for (int x{0}; x < observed.width; ++x) {
      const Likelihood likelihood{likelihood_of(input.config, observed(x, y))};
      const float occupancy{joint ? joint_cell(step, x, y, likelihood, state)
                                  : tay_cell(step, x, y, likelihood, state, occupied)};
      const std::vector<float>& weights{joint ? state : occupied};
      float vx{0};
      float vy{0};
      for (std::size_t k{0}; k < state.size(); ++k) {
        after.velocity[k](x, y) = state[k];
        vx += weights[k] * static_cast<float>(input.lattice[k].x);
        vy += weights[k] * static_cast<float>(input.lattice[k].y);
      }
      const bool seen{std::abs(observed(x, y) - 0.5f) > observed_difference};
      after.occupancy(x, y) = layers.occupancy(x, y) = occupancy;
      after.age_s(x, y) = layers.age_s(x, y) = seen ? 0.0f : step.age_before(x, y) + static_cast<float>(input.dt_s);
      layers.velocity_x(x, y) = vx / occupancy;
      layers.velocity_y(x, y) = vy / occupancy;
    }
  }
}

}  // namespace stereogrid
