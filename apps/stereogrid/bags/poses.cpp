// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "bags/poses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bags/decode.hpp"
#include "bags/topics.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/tf2_msgs.hpp"

namespace stereogrid::app {
namespace {

using messages::nav_msgs::Odometry;
using messages::tf2_msgs::TFMessage;

/// Heading of the x axis, seen from above.
template <class Place>
Pose2 on_the_ground(const Place& place, const messages::geometry_msgs::Quaternion& q) {
  return {place.x, place.y, std::atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))};
}

bool is_frame(const std::string& frame, const char* name) {
  return frame == name || frame == std::string{"/"} + name;  // ROS 1 had the slash
}

/// Calls `take` with every message of a topic that is one.
template <class M, class Take>
void for_each(const mcap::Bag& bag, const std::string& topic, Take&& take) {
  const auto cursor{bag.messages({.topics = {topic}})};
  M one;
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      messages::decode(message->data, one);
    } catch (const InputError&) {
      continue;
    }
    take(one);
  }
}

void add(std::vector<io::StampedPose>& poses, const messages::std_msgs::Header& header, const Pose2& pose) {
  const bool is_finite{std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad)};
  if (is_finite) poses.push_back({ns_of(header.stamp), pose});
}

void put_in_order(std::vector<io::StampedPose>& poses) {
  std::ranges::stable_sort(poses, {}, &io::StampedPose::stamp_ns);
  const auto is_same = [](const io::StampedPose& a, const io::StampedPose& b) { return a.stamp_ns == b.stamp_ns; };
  poses.erase(std::unique(poses.begin(), poses.end(), is_same), poses.end());
}

}  // namespace

void add_poses(std::vector<io::StampedPose>& poses, const Odometry& message) {
  add(poses, message.header, on_the_ground(message.pose.pose.position, message.pose.pose.orientation));
}

void add_poses(std::vector<io::StampedPose>& poses, const TFMessage& message) {
  for (const auto& one : message.transforms) {
    if (!is_frame(one.header.frame_id, "odom") || !is_frame(one.child_frame_id, "base_link")) continue;
    add(poses, one.header, on_the_ground(one.transform.translation, one.transform.rotation));
  }
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
    for_each<Odometry>(bag, topics.front(), [&](const Odometry& one) { add_poses(found.poses, one); });
  } else if (const mcap::Topic* const tf{find_topic(bag.topics(), "/tf")};
             tf != nullptr && tf->type == TFMessage::type_name) {
    found.source = "/tf (odom → base_link)";
    for_each<TFMessage>(bag, "/tf", [&](const TFMessage& message) { add_poses(found.poses, message); });
  }
  put_in_order(found.poses);
  return found;
}

}  // namespace stereogrid::app
