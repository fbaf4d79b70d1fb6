// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "live/live.hpp"
#include "pose_stage.hpp"
#include "stereogrid/capture/frame_loop.hpp"
#include "stereogrid/capture/latest.hpp"

namespace stereogrid::app {

/// Frames of a live source with their poses, which are found on a thread of its own: a frame's while the pipeline works
/// on the one before. Never more than one waits. All functions are for one thread.
class PlacedFrames {
 public:
  /// The input has to live longer.
  explicit PlacedFrames(const LiveInput& input);
  PlacedFrames(const PlacedFrames&) = delete;
  PlacedFrames& operator=(const PlacedFrames&) = delete;
  ~PlacedFrames();

  /// As LiveSource::next(); unusable frames are reported and counted. Throws other errors that end the source.
  [[nodiscard]] std::optional<capture::PreparedFrame> next(std::chrono::milliseconds patience);
  [[nodiscard]] bool has_ended() const { return latest_.has_ended() && !failure_; }
  /// By the source, and here.
  [[nodiscard]] std::vector<capture::Drop> dropped() const;
  /// Frames that are not placed yet are another stream's; one that waits already is not.
  void request_reset() { is_reset_requested_ = true; }

 private:
  struct PlacedFrame {
    capture::PreparedFrame prepared;
    std::int64_t stream;  ///< frames of another stream do not belong to it
  };

  void place_all();
  void place_next();
  void take(capture::LiveFrame live);
  void log_unusable(const std::string& reason);

  const LiveInput& input_;
  capture::Latest<PlacedFrame> latest_;
  std::atomic<bool> is_reset_requested_{false};
  std::atomic<bool> is_to_stop_{false};
  std::atomic<std::int64_t> refused_{0};
  std::int64_t taken_stream_{0};  ///< last frame of next()
  std::exception_ptr failure_;    // before latest_ ends
  // used by the thread
  std::optional<PoseStage> poses_;
  std::int64_t stream_{0};
  std::string reported_;
  std::thread thread_;
};

}  // namespace stereogrid::app
