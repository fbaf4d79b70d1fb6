// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/frame_messages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "stereogrid/error.hpp"
#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::messages {
namespace {

constexpr float nothing_there{std::numeric_limits<float>::infinity()};
constexpr float nothing_known{std::numeric_limits<float>::quiet_NaN()};
constexpr double steps_per_cell{4};
constexpr std::size_t cameras_max{8};  // limit of a pipeline

constexpr double pi{std::numbers::pi};
constexpr double rounding_rad{1e-9};

// Bearings, rad, counter-clockwise.
struct Bearings {
  double right_rad;
  double left_rad;
};

// The camera's field of view, in the axes of the vehicle.
Bearings view_of(const Rig& rig) {
  const HorizontalView view{horizontal_view(rig)};
  return {rig.camera_yaw_rad + view.right_rad, rig.camera_yaw_rad + view.left_rad};
}

// `rad` plus full turns: at `from_rad` or up to a turn later.
double turned_beyond(double from_rad, double rad) {
  return rad + 2 * pi * std::ceil((from_rad - rad) / (2 * pi));
}

// The smallest range with all fields of view, at most a turn.
Bearings views_of(std::span<const Rig> rigs) {
  Bearings smallest{-pi, pi};
  for (const Rig& first : rigs) {  // the range begins at the right edge of one of them
    Bearings view{view_of(first)};
    for (const Rig& rig : rigs) {
      if (&rig == &first) continue;
      const Bearings other{view_of(rig)};
      const double right_rad{turned_beyond(view.right_rad, other.right_rad)};
      view.left_rad = std::max(view.left_rad, right_rad + (other.left_rad - other.right_rad));
    }
    if (view.left_rad - view.right_rad < smallest.left_rad - smallest.right_rad) smallest = view;
  }
  return smallest;
}

// Length of a beam from the origin within the grid, m.
double length_within(const GridGeometry& grid, double bearing_rad) {
  const auto until = [&](double along, double begin_m, int cells) {
    if (std::abs(along) < rounding_rad) return std::numeric_limits<double>::infinity();
    return (along > 0 ? begin_m + cells * grid.cell_size_m : begin_m) / along;
  };
  return std::min(until(std::cos(bearing_rad), grid.x_min_m, grid.nx),
                  until(std::sin(bearing_rad), grid.y_min_m, grid.ny));
}

// Length of the shortest beam of those in the grid, m. It is at an end, or square to a side of the grid.
double reach_m(const GridGeometry& grid, const Bearings& view) {
  double shortest_m{std::numeric_limits<double>::infinity()};
  const auto add = [&](double bearing_rad) {
    const double length_m{length_within(grid, bearing_rad)};
    if (length_m >= grid.cell_size_m) shortest_m = std::min(shortest_m, length_m);
  };
  add(view.right_rad);
  add(view.left_rad);
  for (int i{static_cast<int>(std::ceil(2 * view.right_rad / pi))}; i * pi / 2 < view.left_rad; ++i) add(i * pi / 2);
  return std::isinf(shortest_m) ? grid.cell_size_m : shortest_m;  // the grid is outside the field of view
}

// Ground that a camera can see.
class VisibleGround {
 public:
  explicit VisibleGround(const Rig& rig)
      : camera_from_vehicle_{inverse(camera_place(rig))},
        right_{std::tan(view_of(rig).right_rad - rig.camera_yaw_rad - rounding_rad)},
        left_{std::tan(view_of(rig).left_rad - rig.camera_yaw_rad + rounding_rad)} {
    const double down_rad{std::atan((rig.height_px - 0.5 - rig.cy_px) / rig.focal_px) + rig.camera_pitch_rad};
    if (down_rad > 0) begins_at_m_ = rig.camera_height_m / std::tan(down_rad);
  }

  [[nodiscard]] bool has(Point2 in_vehicle) const {
    const Point2 at{camera_from_vehicle_ * in_vehicle};
    return at.x > begins_at_m_ && at.y >= right_ * at.x && at.y <= left_ * at.x;
  }

 private:
  Pose2 camera_from_vehicle_;
  double right_;
  double left_;
  double begins_at_m_{std::numeric_limits<double>::infinity()};  // straight ahead
};

class Beams {
 public:
  Beams(std::span<const Rig> rigs, const GridGeometry& geometry, View<const float> occupancy)
      : geometry_{geometry}, occupancy_{occupancy} {
    for (const Rig& rig : rigs) visible_[cameras_++] = VisibleGround{rig};
  }

  // Unknown cells count from the nearest visible ground on.
  [[nodiscard]] float range(double bearing_rad, double min_m, double max_m) const {
    const Point2 ahead{std::cos(bearing_rad), std::sin(bearing_rad)};
    const double step_m{geometry_.cell_size_m / steps_per_cell};
    bool is_visible{false};
    bool is_free{true};
    for (double r{min_m}; r < max_m; r += step_m) {
      const Point2 at{r * ahead.x, r * ahead.y};
      const int value{value_at(at)};
      if (value == 100) return static_cast<float>(r);
      is_visible = is_visible || is_seen(at);
      if (value != 0 && is_visible) is_free = false;
    }
    return is_visible && is_free ? nothing_there : nothing_known;
  }

 private:
  [[nodiscard]] bool is_seen(Point2 at) const {
    return std::any_of(visible_.begin(), visible_.begin() + cameras_,
                       [at](const std::optional<VisibleGround>& ground) { return ground->has(at); });
  }

  // 100: occupied, 0: free, −1: unknown.
  [[nodiscard]] int value_at(Point2 at) const {
    const auto cell{geometry_.cell_at(at)};
    return cell ? occupancy_value(occupancy_(cell->ix, cell->iy), OccupancyScale::trinary) : -1;
  }

  const GridGeometry& geometry_;
  View<const float> occupancy_;
  std::array<std::optional<VisibleGround>, cameras_max> visible_{};
  std::size_t cameras_{0};
};

}  // namespace

// The maximum range is the length of the shortest beam within the grid: cells outside are unknown.
void fill(sensor_msgs::LaserScan& message, std::span<const Rig> rigs, const GridGeometry& geometry,
          View<const float> occupancy) {
  if (rigs.empty() || rigs.size() > cameras_max) throw InputError{"A scan needs the rigs of 1 to 8 cameras."};
  const Bearings view{views_of(rigs)};
  const double max_m{reach_m(geometry, view)};
  const double min_m{geometry.cell_size_m / 2};
  // beams are a cell's width apart at the maximum range
  const double span_rad{view.left_rad - view.right_rad};
  const auto beams{static_cast<std::size_t>(std::ceil(span_rad * max_m / geometry.cell_size_m)) + 1};
  const double increment_rad{span_rad / static_cast<double>(beams - 1)};
  message.angle_min = static_cast<float>(view.right_rad);
  message.angle_max = static_cast<float>(view.left_rad);
  message.angle_increment = static_cast<float>(increment_rad);
  message.range_min = static_cast<float>(min_m);
  message.range_max = static_cast<float>(max_m);
  message.ranges.resize(beams);
  const Beams scan{rigs, geometry, occupancy};
  for (std::size_t i{0}; i < beams; ++i) {
    message.ranges[i] = scan.range(view.right_rad + static_cast<double>(i) * increment_rad, min_m, max_m);
  }
}

}  // namespace stereogrid::messages
