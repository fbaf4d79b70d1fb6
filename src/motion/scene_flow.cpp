// SPDX-License-Identifier: Apache-2.0
#include "motion/scene_flow.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "clamped_to_int.hpp"
#include "motion/patch_search.hpp"

namespace stereogrid {
namespace {

// Standard deviations of a tracked patch's position; errors of neighbouring pixels are correlated.
constexpr double sigma_disparity_px{0.15};
constexpr double sigma_column_px{0.2};
/// A rigid thing's points, seen from a moving car, do not agree better.
constexpr double velocity_floor_mps{0.5};

/// Size of the blocks, each with one point at most.
constexpr int block_px{12};

/// Squared gradient per pixel below which a patch is not tracked. Columns determine the velocity; rows only the search
/// area.
constexpr double information_u_min{8};
constexpr double information_v_min{2};
constexpr double range_max_m{40};
constexpr double height_max_m{3};
constexpr double feature_nearest_m{1};
constexpr float disparity_min_px{1};

/// Smoothed patches have less noise than others.
constexpr FindLimits find_limits{5, 0.15};
constexpr double feature_speed_max_mps{45};
/// New points are searched as far as this speed takes them.
constexpr double searched_speed_mps{10};
constexpr int searched_rows{4};
/// Maximum deviation of a row from the pair's epipolar alignment.
constexpr float row_error_max_px{1};

using Grey = View<const std::uint8_t>;

// The first pixel of a lattice at or after `from`.
int lattice_pixel(int from, int first, int step) {
  return from <= first ? first : first + (from - first + step - 1) / step * step;
}

// Sum of grey level changes along some rows of a patch: a first, cheap test.
int texture(const Grey& image, int u, int v) {
  int sum{0};
  for (int j{-patch_reach_v}; j <= patch_reach_v; j += patch_reach_v) {
    const std::uint8_t* row{image.row(v + j) + u - patch_reach_u};
    for (int i{1}; i < patch_columns; ++i) sum += std::abs(row[i] - row[i - 1]);
  }
  return sum;
}

bool can_be_followed(const Template& patch) {
  return information_u(patch) >= information_u_min && information_v(patch) >= information_v_min;
}

int searched_columns(double dt_s, double px_per_m) {
  return std::min(clamped_to_int(searched_speed_mps * dt_s * px_per_m), searched_columns_max);
}

// Place in the right image of a point of the left one.
Place in_right(Place left, float disparity, const RowOffsets& offsets) {
  const float u{left.u - disparity};
  return {u, left.v + static_cast<float>(offsets.at(u, left.v))};
}

// Median of the external disparities around a place where most of them are of one surface.
std::optional<float> disparity_around(View<const float> disparity, Place place) {
  constexpr int around{1};
  constexpr std::size_t least{5};  // most of 3 × 3
  constexpr float same_surface_px{1};
  const int u{rounded(place.u)};
  const int v{rounded(place.v)};
  if (u < around || v < around || u + around >= disparity.width || v + around >= disparity.height) return std::nullopt;
  std::array<float, (2 * around + 1) * (2 * around + 1)> values{};
  std::size_t count{0};
  for (int j{v - around}; j <= v + around; ++j) {
    for (int i{u - around}; i <= u + around; ++i) {
      if (disparity(i, j) > 0) values[count++] = disparity(i, j);
    }
  }
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
  if (count < least) return std::nullopt;
  std::nth_element(values.begin(), middle, end);
  const float median{*middle};
  const auto near = std::count_if(values.begin(), end, [&](float d) { return std::abs(d - median) < same_surface_px; });
  return static_cast<std::size_t>(near) >= least ? std::optional{median} : std::nullopt;
}

}  // namespace

SceneFlow::SceneFlow(const Rig& rig)
    : rig_{rig},
      focal_baseline_pxm_{rig.focal_px * rig.baseline_m},
      blocks_across_{(rig.width_px + block_px - 1) / block_px},
      blocks_down_{(rig.height_px + block_px - 1) / block_px},
      left_before_{rig.width_px, rig.height_px},
      left_{rig.width_px, rig.height_px},
      right_{rig.width_px, rig.height_px},
      ego_error_{rig, 2 * static_cast<std::size_t>(blocks_across_) * static_cast<std::size_t>(blocks_down_)},
      is_taken_(static_cast<std::size_t>(blocks_across_) * static_cast<std::size_t>(blocks_down_)),
      candidates_(is_taken_.size()) {
  points_.reserve(points_reserved());
  vectors_.reserve(points_reserved());
}

Point2 SceneFlow::in_vehicle(Place left, double disparity) const {
  const double x_m{focal_baseline_pxm_ / disparity};
  return {x_m, -(left.u - rig_.cx_px) / rig_.focal_px * x_m};
}

// A point that has been seen once may have moved far: where it is not, as if it stood, it is searched.
std::optional<Place> SceneFlow::in_left(const Point& point, const ScaledPatch& patch, Place expected,
                                        double dt_s) const {
  const std::optional<Place> found{find(left_.view(), patch.pixels(), 0, expected, find_limits)};
  if (found || point.sightings > 1) return found;
  const int columns{searched_columns(dt_s, point.disparity / rig_.baseline_m)};
  const std::optional<Place> start{searched(patch, left_.view(), expected, columns, searched_rows)};
  return start ? find(left_.view(), patch.pixels(), 0, *start, find_limits) : std::nullopt;
}

std::optional<float> SceneFlow::disparity_of(const Point& point, const ScaledPatch& patch, Place left, float expected,
                                             const FlowFrame& frame) const {
  if (frame.right.empty()) return disparity_around(frame.disparity, left);
  const Place start{in_right(left, expected, frame.row_offsets)};
  std::optional<Place> right{find(right_.view(), patch.pixels(), 0, start, find_limits)};
  if (!right && point.sightings == 1) {
    const int columns{searched_columns(frame.dt_s, expected * expected / focal_baseline_pxm_)};
    const std::optional<Place> better{searched(patch, right_.view(), start, columns, 0)};
    if (better) right = find(right_.view(), patch.pixels(), 0, *better, find_limits);
  }
  if (!right || std::abs(right->v - start.v) > row_error_max_px) return std::nullopt;
  return left.u - right->u;
}

bool SceneFlow::follow(int i, const FlowFrame& frame) {
  Point& point{points_[static_cast<std::size_t>(i)]};
  const Point2 last{point.latest[0].place};
  const Point2 at{inverse(frame.world_from_vehicle) *
                  Point2{last.x + point.velocity.x * frame.dt_s, last.y + point.velocity.y * frame.dt_s}};
  if (at.x < feature_nearest_m) return false;
  const auto disparity = static_cast<float>(focal_baseline_pxm_ / at.x);
  // at the same height
  const auto centre_v = static_cast<float>(rig_.cy_px);
  const Place expected{static_cast<float>(rig_.cx_px - rig_.focal_px * at.y / at.x),
                       centre_v + (point.left.v - centre_v) * disparity / point.disparity};
  ScaledPatch patch;
  if (!patch.take(left_before_.view(), point.left, disparity / point.disparity)) return false;
  const std::optional<Place> left{in_left(point, patch, expected, frame.dt_s)};
  if (!left) return false;
  const std::optional<float> found{disparity_of(point, patch, *left, disparity, frame)};
  if (!found || *found < disparity_min_px) return false;
  const Point2 place{frame.world_from_vehicle * in_vehicle(*left, *found)};
  if (std::hypot(place.x - last.x, place.y - last.y) > feature_speed_max_mps * frame.dt_s) return false;
  add_observation(point, *left, *found, place);
  return true;
}

// The velocity is the slope of the line through the latest places (least squares).
void SceneFlow::add_observation(Point& point, Place left, float disparity, Point2 place) const {
  point.left = left;
  point.disparity = disparity;
  std::rotate(point.latest.begin(), point.latest.end() - 1, point.latest.end());
  point.latest[0] = {now_s_, place};
  ++point.sightings;
  const int count{std::min(point.sightings, remembered)};
  double mean_s{0};
  for (int i{0}; i < count; ++i) mean_s += point.latest[static_cast<std::size_t>(i)].time_s / count;
  point.velocity = {};
  point.spread_s2 = 0;
  for (int i{0}; i < count; ++i) {
    const Sighting& sighting{point.latest[static_cast<std::size_t>(i)]};
    const double t_s{sighting.time_s - mean_s};
    point.spread_s2 += t_s * t_s;
    point.velocity.x += t_s * (sighting.place.x - place.x);
    point.velocity.y += t_s * (sighting.place.y - place.y);
  }
  point.velocity.x /= point.spread_s2;
  point.velocity.y /= point.spread_s2;
}

FlowVector SceneFlow::vector_of(const Point& point, const FlowFrame& frame) const {
  const double x_m{focal_baseline_pxm_ / point.disparity};
  const bool has_sigma{frame.right.empty() && frame.external_sigma_px > 0};
  const double sigma_px{has_sigma ? frame.external_sigma_px : sigma_disparity_px};
  const double along_m{sigma_px * x_m / point.disparity};
  const double aside_m{sigma_column_px * x_m / rig_.focal_px};
  const Pose2 turn{0, 0, frame.world_from_vehicle.yaw_rad};
  const Point2 ray{turn * Point2{1, -(point.left.u - rig_.cx_px) / rig_.focal_px}};
  const Point2 side{turn * Point2{0, 1}};
  const auto product = [&](double ray_part, double side_part) {
    return along_m * along_m * ray_part + aside_m * aside_m * side_part;
  };
  const Symmetric2 covariance{product(ray.x * ray.x, side.x * side.x), product(ray.x * ray.y, side.x * side.y),
                              product(ray.y * ray.y, side.y * side.y)};
  return {point.latest[0].place,
          covariance,
          point.velocity,
          widened(1 / point.spread_s2 * covariance, velocity_floor_mps * velocity_floor_mps),
          {}};
}

void SceneFlow::collect(const FlowFrame& frame) {
  std::erase_if(points_, [](const Point& point) { return point.is_lost; });
  vectors_.clear();
  for (const Point& point : points_) vectors_.push_back(vector_of(point, frame));
  ego_error_.correct({frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m}, frame.dt_s, vectors_);
}

void SceneFlow::clear() {
  points_.clear();
  vectors_.clear();
}

void SceneFlow::mark_taken() {
  std::fill(is_taken_.begin(), is_taken_.end(), std::uint8_t{0});
  for (const Point& point : points_) {
    const int column{std::min(rounded(point.left.u) / block_px, blocks_across_ - 1)};
    const int row{std::min(rounded(point.left.v) / block_px, blocks_down_ - 1)};
    is_taken_[static_cast<std::size_t>(row * blocks_across_ + column)] = 1;
  }
}

// The block's best-textured pixel, of those that have matched as obstacles.
std::optional<SceneFlow::Point> SceneFlow::candidate(int block, const FlowFrame& frame, const Matches& matches) const {
  if (is_taken_[static_cast<std::size_t>(block)] != 0) return std::nullopt;
  Place best;
  int most{0};
  const int first_u{block % blocks_across_ * block_px};
  const int first_v{block / blocks_across_ * block_px};
  for (int v{lattice_pixel(first_v, MatchLattice::first_v, MatchLattice::step_v)}; v < first_v + block_px;
       v += MatchLattice::step_v) {
    for (int u{lattice_pixel(first_u, MatchLattice::first_u, MatchLattice::step_u)}; u < first_u + block_px;
         u += MatchLattice::step_u) {
      if (!holds_patch(left_.view(), u, v) || !is_near(v, matches.obstacle(u, v))) continue;
      const int here{texture(left_.view(), u, v)};
      if (here <= most) continue;
      most = here;
      best = {static_cast<float>(u), static_cast<float>(v)};
    }
  }
  Template patch;
  if (most == 0 || !cut(left_.view(), best, 0, patch) || !can_be_followed(patch)) return std::nullopt;
  return point_at(best, patch, frame, matches);
}

bool SceneFlow::is_near(int v, float disparity) const {
  if (disparity < disparity_min_px) return false;
  const double x_m{focal_baseline_pxm_ / disparity};
  const double height_m{rig_.camera_height_m + (rig_.cy_px - v) / rig_.focal_px * x_m};
  return x_m < range_max_m && height_m < height_max_m;
}

std::optional<SceneFlow::Point> SceneFlow::point_at(Place left, const Template& patch, const FlowFrame& frame,
                                                    const Matches& matches) const {
  const auto in_both = [&]() -> std::optional<float> {
    const float matched{matches.obstacle(rounded(left.u), rounded(left.v))};
    const std::optional<Place> right{
        find(right_.view(), patch, 0, in_right(left, matched, frame.row_offsets), find_limits)};
    return right ? std::optional{left.u - right->u} : std::nullopt;
  };
  const std::optional<float> disparity{frame.right.empty() ? disparity_around(frame.disparity, left) : in_both()};
  if (!disparity || *disparity < disparity_min_px) return std::nullopt;
  Point point{left, *disparity, 1, {}, {}, 0, false};
  point.latest[0] = {now_s_, frame.world_from_vehicle * in_vehicle(left, point.disparity)};
  return point;
}

void SceneFlow::take_candidates() {
  for (const std::optional<Point>& point : candidates_) {
    if (point) points_.push_back(*point);
  }
  std::swap(left_, left_before_);
}

}  // namespace stereogrid
