// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "input.hpp"
#include "stereogrid/odometry.hpp"

namespace stereogrid::app {

/// Sees to the poses before the pipeline: leaves the input's own, takes them away, or finds them by visual odometry.
/// Takes the frames in their order, on whatever thread.
class PoseStage {
 public:
  /// Keeps the state of the odometry after every frame for which `is_kept` returns true, for take_state().
  PoseStage(PoseSource poses, const Rig& rig, const Image<std::uint8_t>& mask,
            std::function<bool(std::size_t index)> is_kept = {});

  /// Restores a state, before the first frame. Throws InputError if the state does not fit.
  void load(const OdometryState& state);

  /// Returns a warning, if any. Throws InputError where the frame does not fit the rig.
  std::optional<std::string> place(StereoFrame& frame);

  [[nodiscard]] bool takes_time() const { return odometry_.has_value(); }

  /// State of the odometry after a frame, once; none: poses came with the input, or the frame was not kept.
  [[nodiscard]] std::optional<OdometryState> take_state(std::size_t index);

 private:
  PoseSource poses_;
  std::optional<VisualOdometry> odometry_;
  std::function<bool(std::size_t)> is_kept_;
  std::mutex mutex_;  // frames are placed on other threads than their states are taken on
  std::map<std::size_t, OdometryState> kept_;
};

}  // namespace stereogrid::app
