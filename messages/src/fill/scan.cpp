// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/frame_messages.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::messages {
namespace {

constexpr float nothing_there{std::numeric_limits<float>::infinity()};
constexpr float nothing_known{std::numeric_limits<float>::quiet_NaN()};
constexpr double steps_per_cell{4};

// Bearings of the camera's field of view, rad, counter-clockwise.
struct FieldOfView {
  explicit FieldOfView(const Rig& rig)
      : right_rad{-std::atan((rig.width_px - 0.5 - rig.cx_px) / rig.focal_px)},
        left_rad{std::atan((rig.cx_px + 0.5) / rig.focal_px)} {}

  double right_rad;
  double left_rad;
};

// Length of a beam from the origin within the grid, m.
double length_within(const GridGeometry& grid, double bearing_rad) {
  const double x_max_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  const double y_end_m{bearing_rad > 0 ? grid.y_min_m + grid.ny * grid.cell_size_m : grid.y_min_m};
  const double ahead{x_max_m / std::cos(bearing_rad)};
  return bearing_rad == 0 ? ahead : std::min(ahead, y_end_m / std::sin(bearing_rad));
}

// Distance of the nearest visible road straight ahead, m; infinite: none.
double road_begins_at(const Rig& rig) {
  const double down_rad{std::atan((rig.height_px - 0.5 - rig.cy_px) / rig.focal_px) + rig.camera_pitch_rad};
  return down_rad > 0 ? rig.camera_height_m / std::tan(down_rad) : std::numeric_limits<double>::infinity();
}

class Beam {
 public:
  Beam(const GridGeometry& geometry, View<const float> occupancy, double bearing_rad)
      : geometry_{geometry}, occupancy_{occupancy}, c_{std::cos(bearing_rad)}, s_{std::sin(bearing_rad)} {}

  // `seen_from_m`: distance of the nearest visible ground.
  [[nodiscard]] float range(double min_m, double max_m, double seen_from_m) const {
    const double step_m{geometry_.cell_size_m / steps_per_cell};
    bool is_seen_free{seen_from_m < max_m * c_};
    for (double r{min_m}; r < max_m; r += step_m) {
      const int value{value_at(r)};
      if (value == 100) return static_cast<float>(r);
      if (value != 0 && r * c_ > seen_from_m) is_seen_free = false;
    }
    return is_seen_free ? nothing_there : nothing_known;
  }

 private:
  // 100: occupied, 0: free, −1: unknown.
  [[nodiscard]] int value_at(double range_m) const {
    const auto cell{geometry_.cell_at({range_m * c_, range_m * s_})};
    return cell ? occupancy_value(occupancy_(cell->ix, cell->iy), OccupancyScale::trinary) : -1;
  }

  const GridGeometry& geometry_;
  View<const float> occupancy_;
  double c_;
  double s_;
};

}  // namespace

// The maximum range is the length of the shortest beam within the grid: cells outside are unknown.
void fill(sensor_msgs::LaserScan& message, const Rig& rig, const GridGeometry& geometry, View<const float> occupancy) {
  const FieldOfView view{rig};
  const double straight_rad{std::clamp(0.0, view.right_rad, view.left_rad)};
  const double reach_m{std::min({length_within(geometry, view.right_rad), length_within(geometry, view.left_rad),
                                 length_within(geometry, straight_rad)})};
  const double max_m{
      std::max(reach_m, geometry.cell_size_m)};  // an empty range if the grid is outside the field of view
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
  const double seen_from_m{road_begins_at(rig)};
  for (std::size_t i{0}; i < beams; ++i) {
    const Beam beam{geometry, occupancy, view.right_rad + static_cast<double>(i) * increment_rad};
    message.ranges[i] = beam.range(min_m, max_m, seen_from_m);
  }
}

}  // namespace stereogrid::messages
