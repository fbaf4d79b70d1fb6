// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/io/poses.hpp"
#include "stereogrid/mcap/bag.hpp"

namespace stereogrid::rosbag {

/// Number of poses that messages had, and of those that were dropped, by reason.
struct PoseTally {
  std::size_t poses{0};              ///< with those dropped; a message that cannot be decoded counts as one
  std::size_t undecodable{0};        ///< messages that are cut short or of another type
  std::size_t not_finite{0};         ///< NaN or infinity in the position or the orientation
  std::size_t not_unit{0};           ///< quaternions of another length than 1
  double first_length{0};            ///< length of the first one
  std::size_t too_far{0};            ///< positions beyond io::largest_position_m
  std::size_t contradicting{0};      ///< another pose has the same stamp
  std::set<std::string> transforms;  ///< transforms on /tf between other frames: five at most

  [[nodiscard]] std::size_t dropped() const { return undecodable + not_finite + not_unit + too_far + contradicting; }
  /// "2 of 3 poses are dropped (…)", with the reasons; empty: none.
  [[nodiscard]] std::string text() const;
};

/// Adds the poses of the vehicle on the ground that a message has: of nav_msgs/Odometry, or of the transform
/// odom → base_link in a tf2_msgs/TFMessage. `type`: type_name of one of them. Dropped poses are counted.
void add_poses(std::vector<io::StampedPose>& poses, PoseTally& tally, std::string_view type,
               std::span<const std::byte> cdr);

/// Poses of the vehicle in a bag, by stamp; all stamps differ.
struct BagPoses {
  std::vector<io::StampedPose> poses;  ///< fewer than two: none
  std::string source;                  ///< topic and type; empty: the bag has no such topic
  std::string others;                  ///< topics that could have been taken, too; empty: none
  PoseTally tally;
};

/// Poses of the first nav_msgs/Odometry by name, else of the transform odom → base_link on /tf.
[[nodiscard]] BagPoses poses_of(const mcap::Bag& bag);

}  // namespace stereogrid::rosbag
