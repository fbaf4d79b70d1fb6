// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "input.hpp"
#include "stereogrid/io/odometry.hpp"

namespace stereogrid::app {

/// Sees to the poses before the pipeline: leaves the input's own, takes them away, or finds them by visual odometry.
/// Takes the frames in their order, on whatever thread.
class PoseStage {
 public:
  explicit PoseStage(const Input& input);

  /// Returns a warning; empty: none. Throws InputError where the frame does not fit the rig.
  std::string place(StereoFrame& frame);

  [[nodiscard]] bool takes_time() const { return odometry_.has_value(); }

 private:
  PoseSource poses_;
  std::optional<io::VisualOdometry> odometry_;
};

}  // namespace stereogrid::app
