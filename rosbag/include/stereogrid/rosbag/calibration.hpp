// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/io/calibration.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/rosbag/topics.hpp"

namespace stereogrid::rosbag {

/// A camera's calibration, and the topic that it came from.
struct NamedInfo {
  messages::sensor_msgs::CameraInfo message;
  std::string name;   ///< of the bag and the topic, for complaints
  std::string topic;  ///< for people
};

/// Adds the first message of each camera to those of a topic that several cameras share: cameras differ in frame_id or
/// in P[3]. The left camera comes first. Of more than two cameras three are kept.
void add_camera(std::vector<messages::sensor_msgs::CameraInfo>& cameras,
                const messages::sensor_msgs::CameraInfo& message);

/// What both say of images of this size. Throws InputError: they are not of such a pair.
[[nodiscard]] io::Calibration calibration_of(NamedInfo left, NamedInfo right, bool are_rectified, int width_px,
                                             int height_px);

/// What the first CameraInfo of each camera says of images of this size, which are rectified where the topics' names
/// say so, or where nothing is left to do. Both cameras' messages may be on one topic. Throws InputError: a camera has
/// none, or it is not of such a pair.
[[nodiscard]] io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                             int width_px, int height_px);

}  // namespace stereogrid::rosbag
