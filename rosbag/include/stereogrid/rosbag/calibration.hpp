// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
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
  std::string name;   ///< bag and topic, for messages
  std::string topic;  ///< for people
};

/// Adds the first message of each camera to those of a topic that several cameras share: cameras differ in frame_id or
/// in P[3]. The left camera comes first. Of more than two cameras three are kept.
void add_camera(std::vector<messages::sensor_msgs::CameraInfo>& cameras,
                const messages::sensor_msgs::CameraInfo& message);

/// Calibration from both messages, for images of this size. Throws InputError: not a stereo pair.
[[nodiscard]] io::Calibration calibration_of(NamedInfo left, NamedInfo right, bool are_rectified, int width_px,
                                             int height_px);

/// Topics of CameraInfo for images with depth; empty: not there.
struct DepthInfoTopics {
  std::string images;  ///< beside the images, else beside their depth, else the only one
  std::string depth;
  std::string right;  ///< name of the right camera, whose baseline is that of the depth
};
[[nodiscard]] DepthInfoTopics depth_info_topics(const mcap::Topic& images, const mcap::Topic& depth,
                                                const std::vector<std::string>& there);

/// Baseline of a right camera, m; 0: the message has none.
[[nodiscard]] double baseline_m_of(const messages::sensor_msgs::CameraInfo& right);

/// Messages that calibrate images with depth.
struct DepthInfos {
  NamedInfo images;
  std::optional<NamedInfo> depth;  ///< none: taken as aligned to the images
  double baseline_m{0};            ///< 0: unknown
};

/// Calibration of images of this size with depth: one camera and a baseline, a virtual one where none is known or the
/// known one is short. `images`: the topic of `topics.left`. Throws InputError: depth of another camera; disparities
/// of raw images.
[[nodiscard]] io::Calibration calibration_of(DepthInfos infos, const mcap::Topic& images, const ImageTopics& topics,
                                             int width_px, int height_px);

/// Calibration from the first CameraInfo of each camera, for images of this size. They are rectified if the topics'
/// names say so, or if rectification would change nothing. Both cameras' messages may be on one topic. Throws
/// InputError: a camera has none, or they are not of a pair.
[[nodiscard]] io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics,
                                             int width_px, int height_px);

}  // namespace stereogrid::rosbag
