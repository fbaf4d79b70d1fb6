// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::rosbag {

/// Content of the second topic: the right images; depth or disparities of the left images; or the first topic again,
/// whose images are left and right beside each other, or left above right.
enum class SecondTopic { right, depth, disparity, beside, below };

/// Topics of the images of a bag.
struct ImageTopics {
  std::string left;
  std::string right;
  SecondTopic second{SecondTopic::right};

  [[nodiscard]] bool has_depth() const { return second == SecondTopic::depth || second == SecondTopic::disparity; }
  [[nodiscard]] bool is_one_topic() const { return second == SecondTopic::beside || second == SecondTopic::below; }
};

/// The second topic for people: "depth of /camera/depth", "disparities of …", or its name alone.
[[nodiscard]] std::string second_of(const ImageTopics& topics);

/// Encodings of the first messages (sensor_msgs/Image) by topic.
using Encodings = std::map<std::string, std::string>;

/// Returns the requested topics; "": found by their names. Pairs come before depth and disparities, these before a
/// single topic, which is `beside` until its images are seen. `bag`: for messages. `encodings`: may lack topics. Throws
/// InputError, which lists the candidates: there is no pair, or more than one camera has one.
[[nodiscard]] ImageTopics choose_image_topics(const std::string& bag, const std::vector<mcap::Topic>& topics,
                                              const ImageTopics& asked, const Encodings& encodings = {});

/// True for sensor_msgs/Image and CompressedImage with messages, depth left out where the name says so.
[[nodiscard]] bool holds_images(const mcap::Topic& topic);
/// Content of a topic as the second one; none: neither depth nor disparities.
[[nodiscard]] std::optional<SecondTopic> depth_kind_of(const mcap::Topic& topic, const Encodings& encodings);

/// nullptr: there is no such topic, or nothing on it.
[[nodiscard]] const mcap::Topic* find_topic(const std::vector<mcap::Topic>& topics, const std::string& name);

/// The right camera's topic by the name of the left camera's; empty: the name has no side.
[[nodiscard]] std::string right_name_of(const std::string& left);

/// CameraInfo topic of a camera, beside its images.
[[nodiscard]] std::string info_topic_of(const mcap::Topic& images);
/// The one of these topics of CameraInfo that is called after the images (image_left: camera_info_left; left:
/// left_info, left/camera_info), else that beside them, which may not be there.
[[nodiscard]] std::string info_topic_of(const mcap::Topic& images, const std::vector<std::string>& there);
/// True if the topic's name says that the images are rectified.
[[nodiscard]] bool is_rectified(const mcap::Topic& images);
[[nodiscard]] bool is_compressed(const mcap::Topic& images);

}  // namespace stereogrid::rosbag
