// SPDX-License-Identifier: Apache-2.0
#include "live/live.hpp"

#include <spdlog/spdlog.h>

#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid::app {

using namespace std::chrono_literals;
using capture::Clock;
using capture::LiveFrame;

PlacedFrames::PlacedFrames(const LiveInput& input) : input_{input}, thread_{[this] { place_all(); }} {}

PlacedFrames::~PlacedFrames() {
  is_to_stop_ = true;
  thread_.join();
}

std::optional<capture::PreparedFrame> PlacedFrames::next(std::chrono::milliseconds patience) {
  std::optional<PlacedFrame> placed{latest_.take(patience)};
  if (!placed && latest_.has_ended() && failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  if (!placed) return std::nullopt;
  placed->prepared.resets_before = placed->stream != std::exchange(taken_stream_, placed->stream);
  return std::move(placed->prepared);
}

std::vector<capture::Drop> PlacedFrames::dropped() const {
  std::vector<capture::Drop> drops{input_.source->dropped()};
  drops.push_back({"the pipeline was busy", latest_.replaced()});
  drops.push_back({"do not fit the odometry", refused_});
  std::erase_if(drops, [](const capture::Drop& drop) { return drop.frames == 0; });
  return drops;
}

void PlacedFrames::place_all() {
  try {
    while (!is_to_stop_ && !input_.source->has_ended()) place_next();
  } catch (...) {
    failure_ = std::current_exception();
  }
  latest_.end();
}

void PlacedFrames::place_next() {
  try {
    if (std::optional<LiveFrame> live{input_.source->next(100ms)}) take(std::move(*live));
  } catch (const InputError& error) {  // the source counts it
    log_unusable(error.what());
  }
}

void PlacedFrames::take(LiveFrame live) {
  if (is_reset_requested_.exchange(false) || live.resets_before || !poses_) {
    poses_.emplace(input_.poses, input_.source->rig(), input_.mask);
    ++stream_;
  }
  PlacedFrame placed{{.frame = std::move(live.frame), .captured = live.captured, .recorded = live.recorded}, stream_};
  const Clock::time_point begun{Clock::now()};
  try {
    PoseStage::Placed pose{poses_->place(placed.prepared.frame)};
    placed.prepared.warning = std::move(pose.warning);
    placed.prepared.covariances = pose.covariances;
  } catch (const InputError& error) {
    ++refused_;
    return log_unusable(error.what());
  }
  if (poses_->takes_time())
    placed.prepared.odometry_ms = std::chrono::duration<double, std::milli>{Clock::now() - begun}.count();
  latest_.put(std::move(placed));
}

void PlacedFrames::log_unusable(const std::string& reason) {
  if (reason != reported_) spdlog::warn("a frame cannot be used: {}", reason);
  reported_ = reason;
}

}  // namespace stereogrid::app
