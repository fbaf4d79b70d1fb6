// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/evaluation/lidar_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "level_points.hpp"

namespace stereogrid::evaluation {
namespace {

std::vector<Point2> directions_of(int beams) {
  std::vector<Point2> directions;
  for (int i{0}; i < beams; ++i) {
    const double angle{(i + 0.5) * 2 * std::numbers::pi / beams - std::numbers::pi};
    directions.push_back({std::cos(angle), std::sin(angle)});
  }
  return directions;
}

}  // namespace

Image<float> lidar_grid(std::span<const CameraPoint> points, const CameraPoint& lidar, const Rig& rig,
                        const GridGeometry& grid, double camera_height_m, const LidarModelParameters& parameters) {
  const LevelFrame level_frame{rig};
  const std::vector<CameraPoint> level{level_frame(points)};
  const CameraPoint sensor{level_frame(lidar)};
  const LogOddsParameters& log_odds{parameters.log_odds};
  const int beams{std::max(1, static_cast<int>(std::ceil(2 * std::numbers::pi / parameters.beam_rad)))};
  const Point2 origin{sensor.z_m, -sensor.x_m};
  Fan fan{origin, directions_of(beams), farthest_corner_m(grid) + std::hypot(origin.x, origin.y), grid.cell_size_m / 4};
  const RoadPlane road{fit_road(level, level_frame.road(camera_height_m))};
  for (const CameraPoint& point : level) {
    const double height_m{road.height_of(point)};
    const bool is_hit{height_m >= log_odds.height_min_m && height_m <= log_odds.height_max_m};
    if (!is_hit && std::abs(height_m) > log_odds.road_m) continue;
    const double x{point.z_m - origin.x};
    const double y{-point.x_m - origin.y};
    const int beam{static_cast<int>((std::atan2(y, x) / std::numbers::pi + 1) / 2 * beams)};
    fan.add(static_cast<std::size_t>(std::clamp(beam, 0, beams - 1)), std::hypot(x, y), is_hit);
  }
  return probabilities_of(log_odds_of(fan.cast(grid, {}), log_odds));
}

}  // namespace stereogrid::evaluation
