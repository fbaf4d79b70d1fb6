// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "input.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::app {

/// Motion of the vehicle frame between two frames, by the images and by the poses that came with them.
struct MotionPair {
  Pose2 seen;
  Pose2 external;
};

/// Describes how given poses contradict the motion in the images, and the place of the camera that they would fit;
/// empty: they agree, or nothing is known.
[[nodiscard]] std::optional<std::string> contradiction_of(std::span<const MotionPair> steps);

/// The same of an input with poses of its own, by visual odometry over some frames in the middle of it.
[[nodiscard]] std::optional<std::string> contradiction_of_poses(const Input& input);

}  // namespace stereogrid::app
