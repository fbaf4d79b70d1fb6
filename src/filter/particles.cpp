// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/particles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "clamped_to_int.hpp"
#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr int particles_of_a_full_cell{256};

// The observed grid's edges jump by parts of a cell from frame to frame.
constexpr double position_walk_cells{0.5};  // per √s

}  // namespace

Particles::Particles(int cells, const FilterConfig& config)
    : mass{cells, cells},
      particle(static_cast<std::size_t>(config.particles)),
      arrived(particle.size()),
      cell(particle.size()),
      first(mass.size() + 1),
      begin(mass.size() + 1) {}

Scroll scroll_between(const GridGeometry& before, const GridGeometry& now) {
  return {clamped_to_int(std::round((now.x_min_m - before.x_min_m) / now.cell_size_m)),
          clamped_to_int(std::round((now.y_min_m - before.y_min_m) / now.cell_size_m))};
}

ParticleStep particle_step_of(const FilterInput& input, std::uint64_t number) {
  const FilterConfig& config{input.config};
  const double root{std::sqrt(std::max(input.dt_s, 0.0))};
  ParticleStep step{};
  step.number = number;
  step.kept = static_cast<float>(std::exp(-input.dt_s / config.forgetting_s));
  const double starting{share_within(config.velocity_noise * starting_share, input.dt_s)};
  step.starting = config.velocity_max_mps > 0 ? static_cast<float>(starting) : 0.0f;
  step.renewed = static_cast<float>(share_within(config.velocity_noise, input.dt_s));
  step.static_prior = config.velocity_max_mps > 0 ? static_cast<float>(config.static_prior) : 1.0f;
  step.velocity_max_mps = static_cast<float>(config.velocity_max_mps);
  step.velocity_walk_mps = static_cast<float>(config.velocity_walk_mps * root);
  step.position_walk = static_cast<float>(position_walk_cells * root);
  step.cells_per_mps = static_cast<float>(input.dt_s / input.geometry.cell_size_m);
  return step;
}

double weight_for(double total, int available) {
  return std::max(total / available, 1.0 / particles_of_a_full_cell);
}

void CellUpdate::run(int x, int y, float observed, const ParticleSums& sums) const {
  const Particles& old{before.particles};
  const float arrived{static_cast<float>(sums.count) * old.weight * step.kept};
  const CellMass mass{updated(step, value_before(old.mass, scroll, x, y, {}), arrived,
                              likelihood_of(input.tables.likelihood.data(), observed))};
  after.particles.mass(x, y) = mass;
  write_motion(x, y, mass, sums);
  const float half_unknown{0.5f * mass.unknown()};
  after.occupancy(x, y) = layers.occupancy(x, y) = mass.occupied() + half_unknown;
  layers.moving(x, y) = mass.moving + mass.born + (1 - step.static_prior) * half_unknown;
  const float age{value_before(before.age_s, scroll, x, y, std::numeric_limits<float>::infinity())};
  const bool seen{is_known(observed)};
  after.age_s(x, y) = layers.age_s(x, y) = seen ? 0.0f : age + static_cast<float>(input.dt_s);
}

void CellUpdate::write_motion(int x, int y, const CellMass& mass, const ParticleSums& sums) const {
  const float share{sums.count > 0 ? mass.moving / static_cast<float>(sums.count) : 0.0f};
  // new particles: uniform within ±size, size uniform up to the largest velocity
  const float of_born{mass.born * step.velocity_max_mps * step.velocity_max_mps / 9};
  const VelocityEstimate velocity{estimate_of({mass.occupied(), share * sums.x, share * sums.y,
                                               share * sums.xx + of_born, share * sums.xy, share * sums.yy + of_born})};
  write_velocity(velocity, x, y, layers);
}

}  // namespace stereogrid
