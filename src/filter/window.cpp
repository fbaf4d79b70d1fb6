// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr float never{std::numeric_limits<float>::infinity()};

float interpolated(const Image<float>& cells, double x, double y) {
  const int ix{static_cast<int>(std::floor(x))};
  const int iy{static_cast<int>(std::floor(y))};
  const float fx{static_cast<float>(x - ix)};
  const float fy{static_cast<float>(y - iy)};
  const auto at = [&](int cell_x, int cell_y) {
    return cells(std::clamp(cell_x, 0, cells.width() - 1), std::clamp(cell_y, 0, cells.height() - 1));
  };
  return (1 - fy) * ((1 - fx) * at(ix, iy) + fx * at(ix + 1, iy)) +
         fy * ((1 - fx) * at(ix, iy + 1) + fx * at(ix + 1, iy + 1));
}

}  // namespace

std::vector<Point2> velocity_lattice(const FilterConfig& config) {
  const int steps{static_cast<int>(config.velocity_max_mps / config.velocity_step_mps + 1e-9)};
  std::vector<Point2> lattice;
  for (int j{-steps}; j <= steps; ++j) {
    for (int i{-steps}; i <= steps; ++i) {
      lattice.push_back({i * config.velocity_step_mps, j * config.velocity_step_mps});
    }
  }
  return lattice;
}

Window::Window(const GridGeometry& grid)
    : cell_size_m_{grid.cell_size_m},
      ahead_m_{grid.x_min_m + grid.nx * grid.cell_size_m / 2},
      aside_m_{grid.y_min_m + grid.ny * grid.cell_size_m / 2},
      cells_{static_cast<int>(std::ceil(std::hypot(grid.nx, grid.ny))) + 4} {}

GridGeometry Window::at(const Pose2& world_from_vehicle) const {
  const Point2 centre{world_from_vehicle * Point2{ahead_m_, aside_m_}};
  const int half{cells_ / 2};
  const double first_x{std::floor(centre.x / cell_size_m_) - half};
  const double first_y{std::floor(centre.y / cell_size_m_) - half};
  return {first_x * cell_size_m_, first_y * cell_size_m_, cell_size_m_, cells_, cells_};
}

FilterState::FilterState(int cells, const FilterConfig& config)
    : occupancy{cells, cells, 0.5f}, age_s{cells, cells, never} {
  if (config.model == FilterModel::particles) {
    particles = Particles{cells, config};
  } else {
    velocity.assign(velocity_lattice(config).size(), Image<float>{cells, cells});
  }
}

FilterStep step_of(const FilterInput& input) {
  const FilterConfig& config{input.config};
  const int velocities{static_cast<int>(input.lattice.size())};
  const double others{std::max(velocities - 1, 1) * 1.0};
  FilterStep step{};
  step.velocities = velocities;
  step.forgetting = static_cast<float>((1 - std::exp(-input.dt_s / config.forgetting_s)) / 2);
  step.border_occupancy = config.model == FilterModel::joint ? static_cast<float>(config.border_occupancy) : 0.5f;
  step.kept_standing = step.kept_moving = step.prior_static = 1;
  if (velocities == 1) return step;
  const double noise{config.velocity_noise};
  step.kept_moving = static_cast<float>(1 - noise);
  if (config.static_prior == 0) {
    step.spread = step.start = step.stop = static_cast<float>(noise / velocities);
    step.kept_standing = static_cast<float>(1 - noise + noise / velocities);
    step.prior_static = step.prior_moving = static_cast<float>(1.0 / velocities);
  } else {
    step.spread = static_cast<float>(noise / others);
    step.start = static_cast<float>(noise * starting_share / others);
    step.kept_standing = static_cast<float>(1 - noise * starting_share);
    step.prior_static = static_cast<float>(config.static_prior);
    step.prior_moving = static_cast<float>((1 - config.static_prior) / others);
  }
  return step;
}

Likelihood likelihood_of(const FilterConfig& config, float observed) {
  // 0 and 1 would make a cell deaf to everything that comes later
  const double p{std::clamp(static_cast<double>(observed), 0.001, 0.999)};
  return {static_cast<float>(std::pow(p, config.likelihood_exponent)),
          static_cast<float>(std::pow(1 - p, config.likelihood_exponent))};
}

void reset(FilterState& state, const FilterConfig& config, const GridGeometry& geometry) {
  const std::vector<Point2> lattice{velocity_lattice(config)};
  const FilterStep step{step_of({config, lattice, geometry, 0})};
  const float mass{config.model == FilterModel::joint ? 0.5f : 1.0f};
  state.geometry = geometry;
  for (std::size_t k{0}; k < state.velocity.size(); ++k) {
    state.velocity[k].fill(mass * prior_of(step, static_cast<int>(k)));
  }
  state.particles.mass.fill({});
  state.particles.count = 0;
  state.particles.steps = 0;
  state.occupancy.fill(0.5f);
  state.age_s.fill(never);
}

void resample(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& grid,
              Image<float>& occupancy, Image<float>& velocity_x, Image<float>& velocity_y, Image<float>& age_s) {
  const GridGeometry& window{world.geometry};
  const float c{static_cast<float>(std::cos(world_from_vehicle.yaw_rad))};
  const float s{static_cast<float>(std::sin(world_from_vehicle.yaw_rad))};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 at{world_from_vehicle * Point2{grid.x_min_m + (ix + 0.5) * grid.cell_size_m,
                                                  grid.y_min_m + (iy + 0.5) * grid.cell_size_m}};
      const double x{(at.x - window.x_min_m) / window.cell_size_m};
      const double y{(at.y - window.y_min_m) / window.cell_size_m};
      if (!(x >= 0 && x < window.nx && y >= 0 && y < window.ny)) {
        occupancy(ix, iy) = 0.5f;
        velocity_x(ix, iy) = velocity_y(ix, iy) = 0;
        age_s(ix, iy) = never;
        continue;
      }
      const int nearest_x{static_cast<int>(x)};
      const int nearest_y{static_cast<int>(y)};
      const float vx{world.velocity_x(nearest_x, nearest_y)};
      const float vy{world.velocity_y(nearest_x, nearest_y)};
      occupancy(ix, iy) = interpolated(world.occupancy, x - 0.5, y - 0.5);
      velocity_x(ix, iy) = c * vx + s * vy;
      velocity_y(ix, iy) = -s * vx + c * vy;
      age_s(ix, iy) = world.age_s(nearest_x, nearest_y);
    }
  }
}

}  // namespace stereogrid
