// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/io/poses.hpp"
#include "stereogrid/mcap/bag.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/tf2_msgs.hpp"

namespace stereogrid::app {

/// Where the vehicle is, as a bag says it: in the order of the stamps, which differ.
struct BagPoses {
  std::vector<io::StampedPose> poses;  ///< fewer than two: none
  std::string source;                  ///< the topic, and what of it
  std::string others;                  ///< topics that could have been taken, too; empty: none
};

/// Adds what a message says of the vehicle, on the ground: nothing where its numbers are not finite, or where no
/// transform is that of odom → base_link.
void add_poses(std::vector<io::StampedPose>& poses, const messages::nav_msgs::Odometry& message);
void add_poses(std::vector<io::StampedPose>& poses, const messages::tf2_msgs::TFMessage& message);

/// Of the first nav_msgs/Odometry by name, else of the transform odom → base_link on /tf.
[[nodiscard]] BagPoses poses_of(const mcap::Bag& bag);

}  // namespace stereogrid::app
