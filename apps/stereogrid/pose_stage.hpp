// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "input.hpp"
#include "stereogrid/io/odometry.hpp"

namespace stereogrid::app {

/// Stands before the pipeline and sees to the poses: leaves the input's own, takes them away, or finds them by visual
/// odometry. Takes the frames in their order.
class PoseStage {
 public:
  explicit PoseStage(const Input& input);

  struct Placing {
    double milliseconds{0};
    std::string warning;  ///< empty: none
  };
  /// Throws InputError where the frame does not fit the rig.
  Placing place(StereoFrame& frame);

 private:
  PoseSource poses_;
  std::optional<io::VisualOdometry> odometry_;
};

}  // namespace stereogrid::app
