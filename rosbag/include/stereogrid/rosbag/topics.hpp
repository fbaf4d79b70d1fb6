// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::rosbag {

/// Where the images of a bag are.
struct ImageTopics {
  std::string left;
  std::string right;
};

/// Those that were asked for, "": found by their names. `bag`: for complaints. Throws InputError, which lists the
/// candidates: there is no pair, or more than one camera has one.
[[nodiscard]] ImageTopics choose_image_topics(const std::string& bag, const std::vector<mcap::Topic>& topics,
                                              const ImageTopics& asked);

/// nullptr: there is no such topic, or nothing on it.
[[nodiscard]] const mcap::Topic* find_topic(const std::vector<mcap::Topic>& topics, const std::string& name);

/// Where the camera's calibration is: beside the images.
[[nodiscard]] std::string info_topic_of(const mcap::Topic& images);
/// Does the name say that the images are rectified?
[[nodiscard]] bool is_rectified(const mcap::Topic& images);
[[nodiscard]] bool is_compressed(const mcap::Topic& images);

}  // namespace stereogrid::rosbag
