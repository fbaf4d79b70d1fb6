// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <cstdio>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

using visualization_msgs::Marker;

// values of Marker::type and Marker::action
constexpr std::int32_t cube{1};
constexpr std::int32_t line_strip{4};
constexpr std::int32_t text_facing_the_viewer{9};
constexpr std::int32_t delete_all{3};

constexpr double line_width_m{0.08};
constexpr double text_height_m{0.6};
constexpr std::int32_t lifetime_s{1};  // viewers remove older markers

std_msgs::ColorRGBA colour_of(const Obstacle& obstacle) {
  const float alpha{obstacle.coasting ? 0.4f : 1.0f};
  if (obstacle.moving) return {1.0f, 0.45f, 0.0f, alpha};
  if (obstacle.kind == ObstacleKind::drop) return {0.75f, 0.2f, 0.8f, alpha};
  return obstacle.kind == ObstacleKind::object ? std_msgs::ColorRGBA{0.1f, 0.6f, 1.0f, alpha}
                                               : std_msgs::ColorRGBA{0.6f, 0.6f, 0.6f, alpha};
}

// Overwrites the previous frame's markers and reuses their memory.
class Markers {
 public:
  Markers(std::vector<Marker>& markers, const Pose2& world_from_vehicle, const builtin_interfaces::Time& stamp,
          const std::string& frame)
      : markers_{markers}, world_from_vehicle_{world_from_vehicle}, stamp_{stamp}, frame_{frame} {}

  // removes markers of former obstacles
  void add_delete_all() { next("", cube).action = delete_all; }

  void add_outline(const Obstacle& obstacle) {
    if (obstacle.outline.size() < 2) return;
    Marker& marker{next(obstacle.kind == ObstacleKind::drop ? "drops" : "outlines", line_strip, obstacle)};
    marker.scale.x = line_width_m;
    for (const Point2& point : obstacle.outline) add_point(marker, point);
    if (obstacle.kind == ObstacleKind::object) add_point(marker, obstacle.outline[0]);
  }

  void add_box(const Obstacle& obstacle) {
    Marker& marker{next("boxes", cube, obstacle)};
    const Point2 centre{world_from_vehicle_ * Point2{obstacle.x_m, obstacle.y_m}};
    marker.pose = {{centre.x, centre.y, obstacle.height_m / 2},
                   rotation_about_z(obstacle.yaw_rad + world_from_vehicle_.yaw_rad)};
    marker.scale = {obstacle.length_m, obstacle.width_m, obstacle.height_m};
    marker.color.a *= 0.4f;
  }

  void add_speed(const Obstacle& obstacle) {
    Marker& marker{next("speeds", text_facing_the_viewer, obstacle)};
    const Point2 centre{world_from_vehicle_ * Point2{obstacle.x_m, obstacle.y_m}};
    marker.pose.position = {centre.x, centre.y, obstacle.height_m + text_height_m};
    marker.scale.z = text_height_m;
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1f m/s", std::hypot(obstacle.vx_mps, obstacle.vy_mps));
    marker.text = text.data();
  }

  void finish() { markers_.resize(used_); }

 private:
  void add_point(Marker& marker, Point2 in_vehicle) const {
    const Point2 point{world_from_vehicle_ * in_vehicle};
    marker.points.push_back({point.x, point.y, line_width_m});  // above other drawings on the ground
  }

  Marker& next(const char* name_space, std::int32_t type) {
    if (used_ == markers_.size()) markers_.emplace_back();
    Marker& marker{markers_[used_++]};
    marker.header.stamp = stamp_;
    marker.header.frame_id = frame_;
    marker.ns = name_space;
    marker.id = 0;
    marker.type = type;
    marker.action = 0;
    marker.pose = {};
    marker.scale = {};
    marker.color = {};
    marker.lifetime = {lifetime_s, 0};
    marker.points.clear();
    marker.text.clear();
    return marker;
  }

  Marker& next(const char* name_space, std::int32_t type, const Obstacle& obstacle) {
    Marker& marker{next(name_space, type)};
    marker.id = static_cast<std::int32_t>(obstacle.id & 0x7fffffff);
    marker.color = colour_of(obstacle);
    return marker;
  }

  std::vector<Marker>& markers_;
  Pose2 world_from_vehicle_;
  builtin_interfaces::Time stamp_;
  const std::string& frame_;
  std::size_t used_{0};
};

}  // namespace

void fill(visualization_msgs::MarkerArray& message, const FrameResult& result, const builtin_interfaces::Time& stamp,
          const std::string& world_frame) {
  Markers markers{message.markers, result.world_from_vehicle, stamp, world_frame};
  markers.add_delete_all();
  for (const Obstacle& obstacle : result.obstacles) {
    if (!obstacle.confirmed) continue;
    markers.add_outline(obstacle);
    if (obstacle.kind == ObstacleKind::object) markers.add_box(obstacle);
    if (obstacle.moving) markers.add_speed(obstacle);
  }
  markers.finish();
}

}  // namespace stereogrid::messages
