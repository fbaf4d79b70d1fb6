// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bags/topics.hpp"
#include "stereogrid/io/calibration.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app {

/// A camera's calibration, and the topic that it came from.
struct NamedInfo {
  messages::sensor_msgs::CameraInfo message;
  std::string name;   ///< of the bag and the topic, for complaints
  std::string topic;  ///< for people
};

/// What both say of images of this size. Throws InputError: they are not of such a pair.
[[nodiscard]] io::Calibration calibration_of(const NamedInfo& left, const NamedInfo& right, bool are_rectified,
                                             int width_px, int height_px);

/// What the first CameraInfo of each camera says of images of this size, which are rectified where the topics' names
/// say so, or where nothing is left to do. Throws InputError: there is none, or it is not of such a pair.
[[nodiscard]] io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                             int width_px, int height_px);

}  // namespace stereogrid::app
