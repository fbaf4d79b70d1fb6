// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "fill/fill.hpp"

namespace stereogrid::messages {
namespace {

// FNV-1a.
std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash{0xcbf29ce484222325};
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3;
  return hash;
}

void put(std::uint64_t number, std::span<std::uint8_t, 8> bytes) {
  for (std::size_t i{0}; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(number >> (56 - 8 * i));
}

/// Row-major 3 × 3 in the world's axes; z is not tracked: 0.
std::array<double, 9> in_world(const Covariance2& vehicle, double yaw_rad) {
  const double c{std::cos(yaw_rad)};
  const double s{std::sin(yaw_rad)};
  const double xx{c * c * vehicle.xx - 2 * c * s * vehicle.xy + s * s * vehicle.yy};
  const double xy{c * s * (vehicle.xx - vehicle.yy) + (c * c - s * s) * vehicle.xy};
  const double yy{s * s * vehicle.xx + 2 * c * s * vehicle.xy + c * c * vehicle.yy};
  return {xx, xy, 0, xy, yy, 0, 0, 0, 0};
}

/// 6 × 6 over x, y, z and the rotations about them, of a covariance over x, y and heading in `dt_s`; 0 s: not measured,
/// as z, roll and pitch.
std::array<double, 36> on_ground(const std::array<double, 9>& covariance, double dt_s) {
  constexpr double not_measured{1e6};
  std::array<double, 36> all{};
  for (std::size_t i{0}; i < 6; ++i) all[7 * i] = not_measured;
  if (dt_s == 0) return all;
  constexpr std::array<std::size_t, 3> places{0, 1, 5};
  for (std::size_t row{0}; row < 3; ++row) {
    for (std::size_t column{0}; column < 3; ++column) {
      all[6 * places[row] + places[column]] = covariance[3 * row + column] / (dt_s * dt_s);
    }
  }
  return all;
}

void fill_obstacle(nav2_dynamic_msgs::Obstacle& message, const Obstacle& obstacle, const Pose2& world_from_vehicle) {
  const Point2 centre{world_from_vehicle * Point2{obstacle.x_m, obstacle.y_m}};
  const Pose2 turned{0, 0, world_from_vehicle.yaw_rad};
  const Point2 velocity{turned * Point2{obstacle.vx_mps, obstacle.vy_mps}};
  // the type has no orientation: the box along the axes around the turned one
  const double yaw_rad{obstacle.yaw_rad + world_from_vehicle.yaw_rad};
  const double c{std::abs(std::cos(yaw_rad))};
  const double s{std::abs(std::sin(yaw_rad))};
  put(static_cast<std::uint64_t>(obstacle.id), std::span{message.uuid.uuid}.last<8>());
  message.score = static_cast<float>(obstacle.occupancy);
  message.position = {centre.x, centre.y, obstacle.height_m / 2};
  message.velocity = {velocity.x, velocity.y, 0};
  message.size = {c * obstacle.length_m + s * obstacle.width_m, s * obstacle.length_m + c * obstacle.width_m,
                  std::abs(obstacle.height_m)};  // a drop reaches below the ground
  message.position_covariance = in_world(obstacle.position_covariance, world_from_vehicle.yaw_rad);
  message.velocity_covariance = in_world(obstacle.velocity_covariance, world_from_vehicle.yaw_rad);
}

void fill_detection(vision_msgs::Detection3D& message, const Obstacle& obstacle, const Pose2& world_from_vehicle) {
  const Pose2 pose{world_from_vehicle * Pose2{obstacle.x_m, obstacle.y_m, obstacle.yaw_rad}};
  message.bbox.center = {{pose.x_m, pose.y_m, obstacle.height_m / 2}, rotation_about_z(pose.yaw_rad)};
  message.bbox.size = {obstacle.length_m, obstacle.width_m, std::abs(obstacle.height_m)};
  message.id = std::to_string(obstacle.id);
  message.results.resize(1);
  vision_msgs::ObjectHypothesisWithPose& hypothesis{message.results.front()};
  hypothesis.hypothesis.class_id = names_of(ObstacleKind{})[static_cast<std::size_t>(obstacle.kind)];
  hypothesis.hypothesis.score = obstacle.occupancy;
  hypothesis.pose.pose = message.bbox.center;
  const std::array<double, 9> position{in_world(obstacle.position_covariance, world_from_vehicle.yaw_rad)};
  for (std::size_t row{0}; row < 3; ++row) {
    std::copy_n(position.begin() + 3 * row, 3, hypothesis.pose.covariance.begin() + 6 * row);
  }
  const bool is_known{std::isfinite(obstacle.yaw_sigma_rad)};
  hypothesis.pose.covariance.back() = is_known ? obstacle.yaw_sigma_rad * obstacle.yaw_sigma_rad : 0;
}

}  // namespace

void fill(nav2_dynamic_msgs::ObstacleArray& message, const FrameResult& result, const std::string& node) {
  message.obstacles.clear();
  for (const Obstacle& obstacle : result.obstacles) {
    if (!obstacle.confirmed) continue;  // the type has no field for it
    fill_obstacle(message.obstacles.emplace_back(), obstacle, result.world_from_vehicle);
    put(hash_of(node), std::span{message.obstacles.back().uuid.uuid}.first<8>());
  }
}

void fill(vision_msgs::Detection3DArray& message, const FrameResult& result) {
  std::size_t used{0};
  for (const Obstacle& obstacle : result.obstacles) {
    if (!obstacle.confirmed) continue;
    if (used == message.detections.size()) message.detections.emplace_back();
    vision_msgs::Detection3D& detection{message.detections[used++]};
    detection.header = message.header;
    fill_detection(detection, obstacle, result.world_from_vehicle);
  }
  message.detections.resize(used);
}

namespace {

using geometry_msgs::Quaternion;

// First b, then a.
Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace

builtin_interfaces::Time time_of(std::int64_t stamp_ns) {
  constexpr std::int64_t second_ns{1'000'000'000};
  const std::int64_t nanosec{(stamp_ns % second_ns + second_ns) % second_ns};
  // not stamp_ns - nanosec, which may lie below the range
  const std::int64_t sec{stamp_ns / second_ns - (stamp_ns % second_ns < 0 ? 1 : 0)};
  using Range = std::numeric_limits<std::int32_t>;
  return {static_cast<std::int32_t>(std::clamp<std::int64_t>(sec, Range::min(), Range::max())),
          static_cast<std::uint32_t>(nanosec)};
}

Quaternion rotation_about_z(double yaw_rad) {
  return {0, 0, std::sin(yaw_rad / 2), std::cos(yaw_rad / 2)};
}

// The camera's z becomes the vehicle's x, its x becomes −y, its y becomes −z; then roll (right side down) about the
// vehicle's x, then pitch (down) about its y. It is the inverse of the road's direction in the camera
// (docs/method.md §1.2): (cos pitch · sin roll, cos pitch · cos roll, sin pitch).
geometry_msgs::Transform vehicle_from_camera(const Rig& rig) {
  const Quaternion level{-0.5, 0.5, -0.5, 0.5};
  const Quaternion roll{std::sin(rig.camera_roll_rad / 2), 0, 0, std::cos(rig.camera_roll_rad / 2)};
  const Quaternion pitch{0, std::sin(rig.camera_pitch_rad / 2), 0, std::cos(rig.camera_pitch_rad / 2)};
  const Quaternion ahead{product(pitch, product(roll, level))};
  return {{rig.camera_x_m, rig.camera_y_m, rig.camera_height_m},
          rig.camera_yaw_rad == 0 ? ahead : product(rotation_about_z(rig.camera_yaw_rad), ahead)};
}

geometry_msgs::Transform world_from_vehicle(const Pose2& pose) {
  return {{pose.x_m, pose.y_m, 0}, rotation_about_z(pose.yaw_rad)};
}

void fill(nav_msgs::Odometry& message, const Pose2& world_from_vehicle, const Pose2& moved, double dt_s,
          const std::optional<PoseCovariances>& covariances) {
  message.pose.pose = {{world_from_vehicle.x_m, world_from_vehicle.y_m, 0},
                       rotation_about_z(world_from_vehicle.yaw_rad)};
  message.pose.covariance = covariances ? on_ground(covariances->pose, 1) : std::array<double, 36>{};
  message.twist = {};
  if (covariances) message.twist.covariance = on_ground(covariances->motion, dt_s);
  if (dt_s == 0) return;
  // in the frame of the mean heading
  const Pose2 halfway{0, 0, -moved.yaw_rad / 2};
  const Point2 way{halfway * Point2{moved.x_m, moved.y_m}};
  message.twist.twist.linear = {way.x / dt_s, way.y / dt_s, 0};
  message.twist.twist.angular = {0, 0, moved.yaw_rad / dt_s};
}

}  // namespace stereogrid::messages
