// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::rosbag {

/// View of the pixels of a message, in the machine's byte order. Throws InputError where the message is smaller than it
/// says.
[[nodiscard]] cv::Mat pixels_of(messages::sensor_msgs::Image& message, int type, const std::string& name);

}  // namespace stereogrid::rosbag
