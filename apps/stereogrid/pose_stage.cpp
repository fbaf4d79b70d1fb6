// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pose_stage.hpp"

#include <iterator>
#include <utility>

namespace stereogrid::app {

PoseStage::PoseStage(PoseSource poses, const Rig& rig, const Image<std::uint8_t>& mask,
                     std::function<bool(std::size_t)> is_kept)
    : poses_{poses}, is_kept_{std::move(is_kept)} {
  if (poses_ == PoseSource::odometry) odometry_.emplace(rig, mask);
}

std::optional<std::string> PoseStage::place(StereoFrame& frame) {
  if (poses_ == PoseSource::none) frame.world_from_vehicle.reset();
  if (!odometry_) return std::nullopt;
  OdometryStep step{odometry_->update(frame)};
  frame.world_from_vehicle = step.world_from_vehicle;
  if (const auto index{static_cast<std::size_t>(frame.index)}; is_kept_ && is_kept_(index)) {
    const std::lock_guard lock{mutex_};
    kept_.emplace(index, odometry_->save_state());
  }
  return std::move(step.warning);
}

void PoseStage::load(const OdometryState& state) {
  if (odometry_) odometry_->load_state(state);
}

std::optional<OdometryState> PoseStage::take_state(std::size_t index) {
  const std::lock_guard lock{mutex_};
  const auto found{kept_.find(index)};
  if (found == kept_.end()) return std::nullopt;
  std::optional<OdometryState> state{std::move(found->second)};
  kept_.erase(kept_.begin(), std::next(found));  // erases those of unusable frames, too
  return state;
}

}  // namespace stereogrid::app
