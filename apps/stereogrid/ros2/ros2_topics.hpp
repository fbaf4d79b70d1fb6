// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "input.hpp"
#include "stereogrid/dds/node.hpp"
#include "stereogrid/rosbag/topics.hpp"

namespace stereogrid::app {

/// Start of a SOURCE of ROS 2, before the namespace.
inline constexpr std::string_view ros2_scheme{"ros2:"};

/// Topics that others publish below the namespace of SOURCE, all where the options name topics. `elsewhere`: names of
/// the other topics of images.
[[nodiscard]] std::vector<mcap::Topic> topics_of(const dds::Node& node, const InputOptions& options,
                                                 std::string* elsewhere = nullptr);

struct FoundImages {
  rosbag::ImageTopics images;
  mcap::Topic left;
  mcap::Topic right;
};

/// Topics of left images and of right images or depth, chosen as in bags; logs what it waits for.
[[nodiscard]] FoundImages wait_for_images(dds::Node& node, const InputOptions& options);

}  // namespace stereogrid::app
