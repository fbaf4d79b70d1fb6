// SPDX-License-Identifier: Apache-2.0
#include "baselines/baselines.hpp"

#include <algorithm>
#include <cmath>

#include "baselines/columns.hpp"

namespace stereogrid::research {
namespace {

/// A direction per image column, lengths are depths.
evaluation::Fan fan_of(const DisparityFrame& frame, const GridGeometry& grid,
                       const evaluation::LogOddsParameters& parameters) {
  std::vector<Point2> directions;
  for (int u{0}; u < frame.obstacle.width; ++u) {
    directions.push_back({1, (frame.rig.cx_px - u) / frame.rig.focal_px});
  }
  evaluation::Fan fan{{0, 0}, std::move(directions), evaluation::farthest_corner_m(grid), grid.cell_size_m / 4};
  const RoadModel road{frame.rig, frame.ground};
  for (int v{0}; v < frame.obstacle.height; ++v) {
    for (int u{0}; u < frame.obstacle.width; ++u) {
      const double d{static_cast<double>(std::max(frame.obstacle(u, v), frame.road(u, v)))};
      if (d <= 0) continue;
      const double height_m{road.height_m(u, v, d)};
      const bool is_hit{height_m >= parameters.height_min_m && height_m <= parameters.height_max_m};
      if (!is_hit && std::abs(height_m) > parameters.road_m) continue;
      fan.add(static_cast<std::size_t>(u), frame.rig.focal_px * frame.rig.baseline_m / d, is_hit);
    }
  }
  return fan;
}

std::int64_t cell_of(double x_m, double y_m, double cell_size_m) {
  constexpr std::int64_t row{1LL << 32};
  return static_cast<std::int64_t>(std::floor(y_m / cell_size_m)) * row +
         static_cast<std::int64_t>(std::floor(x_m / cell_size_m));
}

/// The grid's surroundings in the world, in whole cells of a world that has a corner of a cell at its origin.
GridGeometry in_world(const GridGeometry& grid, const Pose2& world_from_vehicle) {
  const double reach_m{evaluation::farthest_corner_m(grid)};
  const double s{grid.cell_size_m};
  const int cells{2 * static_cast<int>(std::ceil(reach_m / s)) + 2};
  return {(std::floor((world_from_vehicle.x_m - reach_m) / s)) * s,
          (std::floor((world_from_vehicle.y_m - reach_m) / s)) * s, s, cells, cells};
}

}  // namespace

Image<float> ray_casting_grid(const DisparityFrame& frame, const GridGeometry& grid,
                              const evaluation::LogOddsParameters& parameters) {
  return evaluation::probabilities_of(
      evaluation::log_odds_of(fan_of(frame, grid, parameters).cast(grid, {}), parameters));
}

LogOddsMap::LogOddsMap(double weight_of_frame, const evaluation::LogOddsParameters& parameters)
    : weight_{weight_of_frame}, parameters_{parameters} {}

Image<float> LogOddsMap::update(const DisparityFrame& frame, const Pose2& world_from_vehicle,
                                const GridGeometry& grid) {
  const GridGeometry world{in_world(grid, world_from_vehicle)};
  const double s{grid.cell_size_m};
  const Image<float> seen{
      evaluation::log_odds_of(fan_of(frame, grid, parameters_).cast(world, world_from_vehicle), parameters_)};
  for (int iy{0}; iy < world.ny; ++iy) {
    for (int ix{0}; ix < world.nx; ++ix) {
      if (seen(ix, iy) == 0) continue;
      float& cell{cells_[cell_of(world.x_min_m + (ix + 0.5) * s, world.y_min_m + (iy + 0.5) * s, s)]};
      const double sum{static_cast<double>(cell) + weight_ * static_cast<double>(seen(ix, iy))};
      cell = static_cast<float>(std::clamp(sum, parameters_.lowest, parameters_.highest));
    }
  }
  Image<float> log_odds{grid.nx, grid.ny};
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 centre{world_from_vehicle * Point2{grid.x_min_m + (ix + 0.5) * s, grid.y_min_m + (iy + 0.5) * s}};
      const auto found{cells_.find(cell_of(centre.x, centre.y, s))};
      if (found != cells_.end()) log_odds(ix, iy) = found->second;
    }
  }
  return evaluation::probabilities_of(std::move(log_odds));
}

}  // namespace stereogrid::research
