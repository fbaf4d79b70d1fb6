// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stereogrid::app {
namespace {

constexpr double moving_above_mps{0.3};
constexpr std::int64_t pixels_min{100};
constexpr double match_within_m{2};
constexpr double nothing{std::numeric_limits<double>::quiet_NaN()};

template <class Test>
double share(const std::vector<float>& values, Test&& test) {
  if (values.empty()) return nothing;
  return static_cast<double>(std::count_if(values.begin(), values.end(), test)) / static_cast<double>(values.size());
}

/// −mean ln of the probability given to the truth.
double log_loss(const std::vector<float>& values, bool occupied) {
  if (values.empty()) return nothing;
  double sum{0};
  for (const float value : values) {
    const double p{std::clamp(static_cast<double>(value), 0.001, 0.999)};
    sum -= std::log(occupied ? p : 1 - p);
  }
  return sum / static_cast<double>(values.size());
}

/// P(an occupied cell is rated above a free one), ties count half.
double auc(const std::vector<float>& occupied, std::vector<float> free) {
  if (occupied.empty() || free.empty()) return nothing;
  std::sort(free.begin(), free.end());
  double sum{0};
  for (const float p : occupied) {
    const auto [below, not_above]{std::equal_range(free.begin(), free.end(), p)};
    sum += static_cast<double>(below - free.begin()) + 0.5 * static_cast<double>(not_above - below);
  }
  return sum / (static_cast<double>(occupied.size()) * static_cast<double>(free.size()));
}

double median(std::vector<double> values) {
  if (values.empty()) return nothing;
  const auto middle{values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)};
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool is_inside(const GridGeometry& grid, Point2 p) {
  return p.x >= grid.x_min_m && p.x < grid.x_min_m + grid.nx * grid.cell_size_m && p.y >= grid.y_min_m &&
         p.y < grid.y_min_m + grid.ny * grid.cell_size_m;
}

const Obstacle* nearest(const std::vector<Obstacle>& found, Point2 place) {
  const Obstacle* best{nullptr};
  double smallest{match_within_m};
  for (const Obstacle& obstacle : found) {
    const double distance{std::hypot(obstacle.x_m - place.x, obstacle.y_m - place.y)};
    if (!obstacle.confirmed || distance > smallest) continue;
    smallest = distance;
    best = &obstacle;
  }
  return best;
}

}  // namespace

void CellScores::add(float probability, bool occupied) {
  (occupied ? occupied_ : free_).push_back(probability);
}

void CellScores::add_hidden_occupied(float probability) {
  hidden_sum_ += static_cast<double>(probability);
  ++hidden_;
}

CellScores::Summary CellScores::summary() const {
  const auto cells{static_cast<double>(occupied_.size() + free_.size())};
  const auto above = [](float limit) { return [limit](float p) { return p > limit; }; };
  const auto below = [](float limit) { return [limit](float p) { return p < limit; }; };
  const auto known = [](float p) { return std::abs(p - 0.5F) > 0.05F; };
  const auto right{std::count_if(occupied_.begin(), occupied_.end(), above(0.5F)) +
                   std::count_if(free_.begin(), free_.end(), [](float p) { return p <= 0.5F; })};
  const auto sure{std::count_if(occupied_.begin(), occupied_.end(), known) +
                  std::count_if(free_.begin(), free_.end(), known)};
  return {occupied_.size() + free_.size(),
          occupied_.size(),
          cells > 0 ? static_cast<double>(right) / cells : nothing,
          share(occupied_, below(0.45F)),
          share(free_, above(0.55F)),
          0.5 * (log_loss(occupied_, true) + log_loss(free_, false)),
          auc(occupied_, free_),
          cells > 0 ? static_cast<double>(sure) / cells : nothing,
          hidden_ > 0 ? hidden_sum_ / static_cast<double>(hidden_) : nothing};
}

void MotionScores::add_objects(const FrameTruth& truth, const GridGeometry& grid, const std::vector<Obstacle>& found) {
  const Pose2 vehicle_from_world{inverse(truth.ego.world_from_vehicle)};
  const Pose2 turn{0, 0, vehicle_from_world.yaw_rad};
  for (const TruthObject& object : truth.objects) {
    if (std::hypot(object.vx_mps, object.vy_mps) <= moving_above_mps || object.pixels < pixels_min) continue;
    const Point2 place{vehicle_from_world * Point2{object.world_from_object.x_m, object.world_from_object.y_m}};
    if (!is_inside(grid, place)) continue;
    ++sightings_;
    const Obstacle* obstacle{nearest(found, place)};
    if (obstacle == nullptr) continue;
    const Point2 velocity{turn * Point2{object.vx_mps, object.vy_mps}};
    speed_errors_mps_.push_back(
        std::abs(std::hypot(obstacle->vx_mps, obstacle->vy_mps) - std::hypot(velocity.x, velocity.y)));
    const double angle{std::atan2(velocity.x * obstacle->vy_mps - velocity.y * obstacle->vx_mps,
                                  velocity.x * obstacle->vx_mps + velocity.y * obstacle->vy_mps)};
    direction_errors_deg_.push_back(std::abs(angle) * 180 / std::numbers::pi);
  }
}

void MotionScores::add_static_cell(float occupancy, float speed_mps) {
  ++static_cells_;
  if (occupancy > 0.6F && speed_mps > 1.0F) ++static_moving_;
}

MotionScores::Summary MotionScores::summary() const {
  return {sightings_,
          speed_errors_mps_.size(),
          median(speed_errors_mps_),
          median(direction_errors_deg_),
          static_cells_,
          static_cells_ > 0 ? static_cast<double>(static_moving_) / static_cast<double>(static_cells_) : nothing};
}

}  // namespace stereogrid::app
