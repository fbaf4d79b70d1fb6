// SPDX-License-Identifier: Apache-2.0
#include "obstacles/tracking/near_obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "clamped_to_int.hpp"
#include "images/patch.hpp"

namespace stereogrid {
namespace {

/// Maximum distance of held obstacles, relative to the distance at which they are lost.
constexpr double near_share{1.5};
constexpr float occupied_min{0.55f};
/// Largest P(occupied) of a held cell.
constexpr float occupancy_max{0.95f};
/// Maximum distance of an obstacle's cells from its outline.
constexpr double beside_m{0.3};
constexpr double infinite{std::numeric_limits<double>::infinity()};

double squared_distance(Point2 at, Point2 a, Point2 b) {
  const Point2 along{b.x - a.x, b.y - a.y};
  const double length{along.x * along.x + along.y * along.y};
  const double share{length > 0 ? ((at.x - a.x) * along.x + (at.y - a.y) * along.y) / length : 0};
  const double t{std::clamp(share, 0.0, 1.0)};
  const double dx{at.x - a.x - t * along.x};
  const double dy{at.y - a.y - t * along.y};
  return dx * dx + dy * dy;
}

// Within the outline of an object, or close to an outline.
bool belongs(Point2 at, const Outline& outline, bool is_closed) {
  bool is_inside{false};
  for (std::size_t i{0}; i < outline.size(); ++i) {
    if (i == 0 && !is_closed && outline.size() > 1) continue;
    const Point2 a{outline[i == 0 ? outline.size() - 1 : i - 1]};
    const Point2 b{outline[i]};
    if (squared_distance(at, a, b) <= beside_m * beside_m) return true;
    const bool crosses{(a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) * (b.x - a.x) / (b.y - a.y)};
    is_inside = is_inside != (is_closed && crosses);
  }
  return is_inside;
}

}  // namespace

NearObstacles::NearObstacles(const Rig& level_rig, const MatchingConfig& matching, int window_cells)
    : rig_{level_rig}, matching_{matching}, is_taken_{window_cells, window_cells} {
  columns_.resize(static_cast<std::size_t>(MatchLattice{rig_.width_px, rig_.height_px}.across));
  cells_.reserve(retained_cells_max);
  states_.reserve(retained_cells_max);
  for (HeldObstacles* held : {&unmatchable_, &present_}) {
    held->cells.reserve(retained_cells_max);
    held->ids.reserve(retained_cells_max);
  }
}

void NearObstacles::clear_result() {
  for (HeldObstacles* held : {&unmatchable_, &present_}) {
    held->cells.clear();
    held->ids.clear();
  }
  states_.assign(cells_.size(), CellState::out_of_view);
}

// Obstacles are lost beyond the disparity search, and in front of all ground in view.
bool NearObstacles::is_near(const Outline& outline, const Ground& road) const {
  const double focal_baseline{rig_.focal_px * rig_.baseline_m};
  const double nearest_road_px{road_plane(rig_, road).disparity(rig_.cx_px, rig_.height_px - 1)};
  const double lost_px{std::min(matching_.disparities - 1.0, std::max(nearest_road_px, 1.0))};
  double nearest_m{infinite};
  for (const Point2& point : outline) {
    if (point.x > 0) nearest_m = std::min(nearest_m, point.x);
  }
  return nearest_m < near_share * focal_baseline / lost_px;
}

void NearObstacles::take_cells(const Obstacle& obstacle, const Outline& outline, const GridLayers& world,
                               const Pose2& world_from_vehicle) {
  const GridGeometry& window{world.geometry};
  Point2 least{infinite, infinite};
  Point2 most{-infinite, -infinite};
  for (const Point2& point : outline) {
    const Point2 at{world_from_vehicle * point};
    least = {std::min(least.x, at.x), std::min(least.y, at.y)};
    most = {std::max(most.x, at.x), std::max(most.y, at.y)};
  }
  const auto index = [&](double at_m, double min_m, int count) {
    return std::clamp(clamped_to_int(std::floor((at_m - min_m) / window.cell_size_m)), 0, count - 1);
  };
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const int first_x{clamped_to_int(std::round(window.x_min_m / window.cell_size_m))};
  const int first_y{clamped_to_int(std::round(window.y_min_m / window.cell_size_m))};
  const int last_x{index(most.x + beside_m, window.x_min_m, window.nx)};
  const int last_y{index(most.y + beside_m, window.y_min_m, window.ny)};
  for (int y{index(least.y - beside_m, window.y_min_m, window.ny)}; y <= last_y; ++y) {
    for (int x{index(least.x - beside_m, window.x_min_m, window.nx)}; x <= last_x; ++x) {
      const float occupancy{world.occupancy(x, y)};
      if (!(occupancy > occupied_min) || is_taken_(x, y) != 0 || cells_.size() >= retained_cells_max) continue;
      if (!belongs(vehicle_from_world * window.centre(x, y), outline, obstacle.kind == ObstacleKind::object)) continue;
      is_taken_(x, y) = 1;
      cells_.push_back({obstacle.id, first_x + x, first_y + y, std::min(occupancy, occupancy_max),
                        static_cast<float>(obstacle.height_m)});
    }
  }
}

void NearObstacles::update(const FrameResult& result, const Tracker& tracker, const Ground& road,
                           const Pose2& world_from_vehicle, bool is_reliable) {
  const GridGeometry& window{result.world.geometry};
  const auto obstacle_of = [&](std::int64_t id) {
    return std::ranges::find(result.obstacles, id, [](const Obstacle& obstacle) { return obstacle.id; });
  };
  const auto is_seen = [&](const Obstacle& obstacle) { return !obstacle.coasting && tracker.is_certain(obstacle.id); };
  std::size_t kept{0};
  for (std::size_t i{0}; i < cells_.size(); ++i) {
    const CellState state{states_[i]};
    const auto obstacle = obstacle_of(cells_[i].id);
    const bool is_tracked{obstacle != result.obstacles.end() && !is_seen(*obstacle)};
    const bool is_held{state == CellState::unmatchable || (!is_reliable && state == CellState::present)};
    if (is_held || (is_tracked && (state == CellState::present || state == CellState::in_view)))
      cells_[kept++] = cells_[i];
  }
  cells_.resize(kept);
  const Pose2 vehicle_from_world{inverse(world_from_vehicle)};
  const auto outline_of = [&](const Obstacle& obstacle) { return tracker.strips_of(obstacle.id, vehicle_from_world); };
  const auto takes = [&](const Obstacle& obstacle) {
    return is_seen(obstacle) && !obstacle.moving && is_near(outline_of(obstacle), road);
  };
  if (std::ranges::none_of(result.obstacles, takes)) return;
  is_taken_.fill(0);
  for (const Cell& cell : cells_) {
    const int x{cell.x - clamped_to_int(std::round(window.x_min_m / window.cell_size_m))};
    const int y{cell.y - clamped_to_int(std::round(window.y_min_m / window.cell_size_m))};
    if (x >= 0 && x < window.nx && y >= 0 && y < window.ny) is_taken_(x, y) = 1;
  }
  for (const Obstacle& obstacle : result.obstacles) {
    if (takes(obstacle)) take_cells(obstacle, outline_of(obstacle), result.world, world_from_vehicle);
  }
  std::ranges::sort(cells_, {}, [](const Cell& cell) { return std::tuple{cell.id, cell.y, cell.x}; });
}

void report_too_close(const HeldObstacles& held, FrameResult& result) {
  const auto is_kept = [&](const Obstacle& obstacle) {
    return obstacle.coasting && std::ranges::binary_search(held.ids, obstacle.id);
  };
  if (std::ranges::none_of(result.obstacles, is_kept)) return;
  result.add(
      FrameStatus::too_close,
      "an obstacle is too close to be matched or fills the view: it is kept as it was observed last. Back off, or set "
      "matching.disparities higher.");
}

}  // namespace stereogrid
