// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/rosbag.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid::rosbag {
namespace {

using messages::geometry_msgs::Quaternion;
using messages::nav_msgs::Odometry;
using messages::std_msgs::Header;
using messages::tf2_msgs::TFMessage;

bool is_frame(const std::string& frame, const char* name) {
  return frame == name || frame == std::string{"/"} + name;  // ROS 1 had the slash
}

/// Adds a pose, its heading that of the x axis seen from above, or counts why it is dropped.
template <class Place>
void add(std::vector<io::StampedPose>& poses, PoseTally& tally, const Header& header, const Place& place,
         const Quaternion& q) {
  ++tally.poses;
  const std::array numbers{place.x, place.y, place.z, q.x, q.y, q.z, q.w};
  if (!std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); })) {
    ++tally.not_finite;
    return;
  }
  if (std::max(std::abs(place.x), std::abs(place.y)) > io::largest_position_m) {
    ++tally.too_far;
    return;
  }
  const auto unit{io::unit_quaternion({q.x, q.y, q.z, q.w})};
  if (!unit) {
    if (tally.not_unit++ == 0) tally.first_length = std::hypot(std::hypot(q.x, q.y), std::hypot(q.z, q.w));
    return;
  }
  const auto& [x, y, z, w]{*unit};
  poses.push_back({ns_of(header.stamp), {place.x, place.y, std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))}});
}

void add(std::vector<io::StampedPose>& poses, PoseTally& tally, const Odometry& message) {
  add(poses, tally, message.header, message.pose.pose.position, message.pose.pose.orientation);
}

void add(std::vector<io::StampedPose>& poses, PoseTally& tally, const TFMessage& message) {
  constexpr std::size_t most_named{5};
  for (const auto& one : message.transforms) {
    if (is_frame(one.header.frame_id, "odom") && is_frame(one.child_frame_id, "base_link")) {
      add(poses, tally, one.header, one.transform.translation, one.transform.rotation);
    } else if (tally.transforms.size() < most_named) {
      tally.transforms.insert(
          fmt::format("{} → {}", io::printable(one.header.frame_id, 40), io::printable(one.child_frame_id, 40)));
    }
  }
}

template <class M>
void decode_and_add(std::vector<io::StampedPose>& poses, PoseTally& tally, std::span<const std::byte> cdr) {
  M message;
  try {
    messages::decode(cdr, message);
  } catch (const InputError&) {
    ++tally.poses;
    ++tally.undecodable;
    return;
  }
  add(poses, tally, message);
}

/// Sets the frames that the first message names.
void find_frames(BagPoses& found, const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  Odometry message;
  try {
    if (const mcap::Message* const first{cursor->next()}) messages::decode(first->data, message);
  } catch (const InputError&) {  // counted where the poses are added
  }
  if (!message.child_frame_id.empty()) found.frame = message.child_frame_id;
  if (!message.header.frame_id.empty()) found.world_frame = message.header.frame_id;
}

void add_all(BagPoses& found, const mcap::Bag& bag, const std::string& topic, std::string_view type) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) add_poses(found.poses, found.tally, type, message->data);
}

/// Sorts by stamp. A pose that is there twice is kept once; of different poses with one stamp the first is kept.
void put_in_order(BagPoses& found) {
  std::ranges::stable_sort(found.poses, {}, &io::StampedPose::stamp_ns);
  std::vector<io::StampedPose> kept;
  for (const io::StampedPose& pose : found.poses) {
    if (kept.empty() || kept.back().stamp_ns != pose.stamp_ns) {
      kept.push_back(pose);
    } else if (kept.back().world_from_vehicle != pose.world_from_vehicle) {
      ++found.tally.contradicting;
    }
  }
  found.poses = std::move(kept);
}

}  // namespace

std::string PoseTally::text() const {
  if (dropped() == 0) return {};
  std::vector<std::string> reasons;
  const auto give = [&](std::size_t count, const std::string& reason) {
    if (count > 0) reasons.push_back(fmt::format("{} {}", count, reason));
  };
  give(undecodable, "cannot be decoded");
  give(not_finite, "not finite (NaN or infinity)");
  give(not_unit, fmt::format("with a quaternion of length {:.4g} (allowed 0.99 to 1.01)", first_length));
  give(too_far, "with a position above 100 million m");
  give(contradicting, "with the stamp of another pose");
  return fmt::format("{} of {} poses are dropped: {}", dropped(), poses, fmt::join(reasons, ", "));
}

void add_poses(std::vector<io::StampedPose>& poses, PoseTally& tally, std::string_view type,
               std::span<const std::byte> cdr) {
  return type == TFMessage::type_name ? decode_and_add<TFMessage>(poses, tally, cdr)
                                      : decode_and_add<Odometry>(poses, tally, cdr);
}

void add_static_transforms(TransformBuffer& transforms, const mcap::Bag& bag) {
  const mcap::Topic* const topic{find_topic(bag.topics(), "/tf_static")};
  if (topic == nullptr || topic->type != TFMessage::type_name) return;
  const auto cursor{bag.messages({.topics = {topic->name}})};
  while (const mcap::Message* const message{cursor->next()}) {
    TFMessage decoded;
    try {
      messages::decode(message->data, decoded);
    } catch (const InputError&) {
      continue;
    }
    static_cast<void>(transforms.add(decoded, true));
  }
}

std::optional<Pose2> camera_in_vehicle(TransformBuffer& transforms, const std::string& vehicle_frame,
                                       const std::string& camera_frame) {
  constexpr std::chrono::milliseconds at_once{0};
  if (camera_frame.empty() || !transforms.are_connected(vehicle_frame, camera_frame, at_once)) return std::nullopt;
  return camera_in_vehicle(transforms.newest(vehicle_frame, camera_frame, at_once));
}

Pose2 camera_in_vehicle(const cv::Affine3d& vehicle_from_camera) {
  constexpr double upright{0.7};  // vertical component of z, cos 45°
  return vehicle_from_camera.matrix(2, 2) > upright ? pose_of_vehicle(vehicle_from_camera)
                                                    : pose_of_camera(vehicle_from_camera);
}

BagPoses poses_of(const mcap::Bag& bag) {
  BagPoses found;
  std::vector<std::string> topics;
  for (const mcap::Topic& topic : bag.topics()) {
    if (topic.type == Odometry::type_name && topic.message_count > 0) topics.push_back(topic.name);
  }
  std::ranges::sort(topics);
  if (!topics.empty()) {
    found.source = fmt::format("{} (nav_msgs/Odometry)", io::printable(topics.front()));
    for (std::size_t i{1}; i < topics.size(); ++i) found.others += " " + io::printable(topics[i]);
    find_frames(found, bag, topics.front());
    add_all(found, bag, topics.front(), Odometry::type_name);
  } else if (const mcap::Topic* const tf{find_topic(bag.topics(), "/tf")};
             tf != nullptr && tf->type == TFMessage::type_name) {
    found.source = "/tf (odom → base_link)";
    add_all(found, bag, "/tf", TFMessage::type_name);
  }
  put_in_order(found);
  return found;
}

}  // namespace stereogrid::rosbag
