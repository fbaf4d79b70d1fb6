// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_stage.hpp"

#include <utility>

namespace stereogrid::app {

PoseStage::PoseStage(const Input& input) : poses_{input.poses} {
  if (poses_ == PoseSource::odometry) odometry_.emplace(input.source->rig());
}

std::string PoseStage::place(StereoFrame& frame) {
  if (poses_ == PoseSource::none) frame.world_from_vehicle.reset();
  if (!odometry_) return "";
  io::OdometryStep step{odometry_->update(frame)};
  frame.world_from_vehicle = step.world_from_vehicle;
  return std::move(step.warning);
}

}  // namespace stereogrid::app
