// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/transforms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/rosbag/rosbag.hpp"

namespace stereogrid::rosbag {
namespace {

constexpr std::int64_t kept_ns{10'000'000'000};
constexpr std::size_t kept_max{20'000};
constexpr std::size_t depth_max{100};  // frames of a chain; tf2 has 1000
constexpr std::int64_t newest_of_each{std::numeric_limits<std::int64_t>::max()};
constexpr double steepest{0.99};  // vertical component of the optical axis

/// ROS 1 had a slash in front.
std::string frame_name(std::string_view name) {
  return std::string{name.starts_with('/') ? name.substr(1) : name};
}

std::string reason_to_drop(const messages::geometry_msgs::TransformStamped& message) {
  const auto& [t, q]{message.transform};
  const std::array numbers{t.x, t.y, t.z, q.x, q.y, q.z, q.w};
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); })) return "it is not finite";
  if (!io::unit_quaternion({q.x, q.y, q.z, q.w})) {
    return fmt::format("its quaternion has length {:.3g} (allowed 0.99 to 1.01)",
                       std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w)));
  }
  const std::string child{frame_name(message.child_frame_id)};
  return child.empty() || child == frame_name(message.header.frame_id) ? "it has no other frame as its parent" : "";
}

}  // namespace

/// A transform, or why there is none.
struct TransformBuffer::Found {
  cv::Affine3d transform{};
  std::string reason{};
  bool may_come{false};  ///< it may arrive later
};

std::string TransformBuffer::add(const messages::tf2_msgs::TFMessage& message, bool are_static) {
  const std::scoped_lock lock{mutex_};
  std::string dropped;
  for (const messages::geometry_msgs::TransformStamped& one : message.transforms) dropped += add(one, are_static);
  changed_.notify_all();
  return dropped;
}

/// The mutex is locked.
std::string TransformBuffer::add(const messages::geometry_msgs::TransformStamped& message, bool is_static) {
  if (const std::string reason{reason_to_drop(message)}; !reason.empty()) {
    if (std::exchange(has_dropped_, true)) return {};
    return fmt::format("/tf: {} → {} is dropped: {}. Correct what publishes it.",
                       io::printable(message.header.frame_id, 40), io::printable(message.child_frame_id, 40), reason);
  }
  const auto& [t, q]{message.transform};
  const Stamped stamped{ns_of(message.header.stamp), cv::Quatd{q.w, q.x, q.y, q.z}.normalize(),
                        cv::Vec3d{t.x, t.y, t.z}};
  Link& link{links_[frame_name(message.child_frame_id)]};
  std::string parent{frame_name(message.header.frame_id)};
  const bool is_another{link.parent != parent || link.is_static != is_static};
  const bool steps_back{!link.history.empty() && stamped.stamp_ns < link.history.back().stamp_ns - kept_ns};
  if (is_static || is_another || steps_back) link.history.clear();
  link.parent = std::move(parent);
  link.is_static = is_static;
  const auto place{std::ranges::lower_bound(link.history, stamped.stamp_ns, {}, &Stamped::stamp_ns)};
  if (place != link.history.end() && place->stamp_ns == stamped.stamp_ns) {
    *place = stamped;
  } else {
    link.history.insert(place, stamped);
  }
  const std::int64_t oldest_ns{link.history.back().stamp_ns - kept_ns};
  if (link.history.size() >= kept_max || link.history.front().stamp_ns < oldest_ns - kept_ns) {  // not at each message
    std::erase_if(link.history, [&](const Stamped& one) { return one.stamp_ns < oldest_ns; });
    if (link.history.size() >= kept_max) link.history.erase(link.history.begin(), link.history.end() - kept_max / 2);
  }
  return {};
}

void TransformBuffer::clear() {
  const std::scoped_lock lock{mutex_};
  std::erase_if(links_, [](const auto& link) { return !link.second.is_static; });
}

cv::Affine3d TransformBuffer::at(const std::string& target, const std::string& source, std::int64_t stamp_ns,
                                 std::chrono::milliseconds patience) {
  return wait_for(target, source, stamp_ns, patience);
}

cv::Affine3d TransformBuffer::newest(const std::string& target, const std::string& source,
                                     std::chrono::milliseconds patience) {
  return wait_for(target, source, newest_of_each, patience);
}

bool TransformBuffer::are_connected(const std::string& target, const std::string& source,
                                    std::chrono::milliseconds patience) {
  try {
    static_cast<void>(newest(target, source, patience));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

cv::Affine3d TransformBuffer::wait_for(const std::string& target, const std::string& source, std::int64_t stamp_ns,
                                       std::chrono::milliseconds patience) {
  const auto end{std::chrono::steady_clock::now() + patience};
  std::unique_lock lock{mutex_};
  for (;;) {
    Found found{find(frame_name(target), frame_name(source), stamp_ns)};
    if (found.reason.empty()) return found.transform;
    if (!found.may_come || changed_.wait_until(lock, end) == std::cv_status::timeout) {
      throw InputError{"/tf", found.reason, "Check that it is published, by the same clock as the images."};
    }
  }
}

/// The frame itself, its parent, and so on.
std::vector<std::string> TransformBuffer::ancestors_of(const std::string& frame) const {
  std::vector<std::string> frames{frame};
  for (auto link{links_.find(frame)}; link != links_.end() && frames.size() < depth_max;) {
    frames.push_back(link->second.parent);
    link = links_.find(link->second.parent);
  }
  return frames;
}

TransformBuffer::Found TransformBuffer::find(const std::string& target, const std::string& source,
                                             std::int64_t stamp_ns) const {
  const std::vector<std::string> of_target{ancestors_of(target)};
  for (const std::string& ancestor : ancestors_of(source)) {
    if (std::ranges::find(of_target, ancestor) == of_target.end()) continue;
    Found from_source{up_to(ancestor, source, stamp_ns)};
    if (!from_source.reason.empty()) return from_source;
    Found from_target{up_to(ancestor, target, stamp_ns)};
    if (from_target.reason.empty()) from_target.transform = from_target.transform.inv() * from_source.transform;
    return from_target;
  }
  return {{}, fmt::format("{} and {} are not connected.", io::printable(target, 60), io::printable(source, 60)), true};
}

TransformBuffer::Found TransformBuffer::up_to(const std::string& ancestor, const std::string& frame,
                                              std::int64_t stamp_ns) const {
  Found all;
  for (std::string child{frame}; child != ancestor;) {
    const Link& link{links_.at(child)};
    Found one{parent_from(child, link, stamp_ns)};
    if (!one.reason.empty()) return one;
    all.transform = one.transform * all.transform;
    child = link.parent;
  }
  return all;
}

TransformBuffer::Found TransformBuffer::parent_from(const std::string& child, const Link& link, std::int64_t stamp_ns) {
  const auto affine{[](const cv::Quatd& rotation, const cv::Vec3d& translation) {
    return cv::Affine3d{rotation.toRotMat3x3(cv::QUAT_ASSUME_UNIT), translation};
  }};
  const std::vector<Stamped>& history{link.history};
  if (link.is_static || stamp_ns == newest_of_each) {
    return {affine(history.back().rotation, history.back().translation)};
  }
  const auto after{std::ranges::lower_bound(history, stamp_ns, {}, &Stamped::stamp_ns)};
  // no numbers in the text: it is logged once
  const auto not_found{[&](const char* what, bool may_come) -> Found {
    return {{},
            fmt::format("{} → {} {} the image.", io::printable(link.parent, 60), io::printable(child, 60), what),
            may_come};
  }};
  if (after == history.end()) return not_found("ends before", true);
  if (after->stamp_ns == stamp_ns) return {affine(after->rotation, after->translation)};
  if (after == history.begin()) return not_found("begins after", false);
  const Stamped& before{*(after - 1)};
  const double part{static_cast<double>(stamp_ns - before.stamp_ns) /
                    static_cast<double>(after->stamp_ns - before.stamp_ns)};
  return {affine(cv::Quatd::slerp(before.rotation, after->rotation, part, cv::QUAT_ASSUME_UNIT),
                 before.translation + part * (after->translation - before.translation))};
}

Pose2 pose_of_camera(const cv::Affine3d& world_from_camera) {
  const cv::Matx44d& m{world_from_camera.matrix};
  return {m(0, 3), m(1, 3), std::atan2(m(1, 2), m(0, 2))};
}

Pose2 pose_of_vehicle(const cv::Affine3d& world_from_vehicle) {
  const cv::Matx44d& m{world_from_vehicle.matrix};
  return {m(0, 3), m(1, 3), std::atan2(m(1, 0), m(0, 0))};
}

bool set_extrinsics(Rig& rig, const cv::Affine3d& ground_from_camera) {
  const cv::Matx44d& m{ground_from_camera.matrix};
  if (m(2, 3) <= 0 || std::abs(m(2, 2)) >= steepest) return false;
  rig.camera_height_m = m(2, 3);
  rig.camera_pitch_rad = std::asin(std::clamp(-m(2, 2), -1.0, 1.0)) + 0.0;  // without −0
  rig.camera_roll_rad = std::atan2(-m(2, 0), -m(2, 1)) + 0.0;
  return true;
}

std::string ground_frame(TransformBuffer& transforms, const std::string& vehicle_frame,
                         const std::string& camera_frame) {
  constexpr const char* on_the_road{"base_footprint"};
  return transforms.are_connected(on_the_road, camera_frame, std::chrono::milliseconds{0}) ? on_the_road
                                                                                           : vehicle_frame;
}

std::string place_camera(io::Calibration& calibration, TransformBuffer& transforms, const std::string& vehicle_frame,
                         const std::string& camera_frame, const std::string& images) {
  constexpr double degrees_per_radian{180 / 3.14159265358979323846};
  const std::optional<Pose2> place{camera_in_vehicle(transforms, vehicle_frame, camera_frame)};
  if (!place) {
    throw InputError{
        images,
        fmt::format("/tf_static does not connect {} with '{}', the frame of these images: the camera's place is "
                    "unknown.",
                    io::printable(vehicle_frame, 60), io::printable(camera_frame, 60)),
        "Publish the robot's description (robot_state_publisher) or static_transform_publisher, and record /tf_static; "
        "or extract the images into folders, with a mount in each calibration.yaml."};
  }
  Rig& rig{calibration.rig};
  rig.camera_x_m = place->x_m;
  rig.camera_y_m = place->y_m;
  rig.camera_yaw_rad = place->yaw_rad;
  std::string text{fmt::format("{:.2f} m ahead, {:.2f} m and {:.1f}° to the left in {}", rig.camera_x_m, rig.camera_y_m,
                               rig.camera_yaw_rad * degrees_per_radian, io::printable(vehicle_frame, 60))};
  const std::string ground{ground_frame(transforms, vehicle_frame, camera_frame)};
  const bool is_above{set_extrinsics(rig, transforms.newest(ground, camera_frame, std::chrono::milliseconds{0}))};
  calibration.has_extrinsics = is_above && ground == "base_footprint";
  if (!is_above) return text + ", not above the road: height, pitch and roll are estimated";
  return text + fmt::format(", {:.2f} m above {}{}", rig.camera_height_m, io::printable(ground, 60),
                            calibration.has_extrinsics ? "" : " (checked against the road)");
}

}  // namespace stereogrid::rosbag
