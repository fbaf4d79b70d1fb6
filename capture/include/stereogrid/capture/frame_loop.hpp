// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/pose_covariances.hpp"

namespace stereogrid::capture {

/// A frame for a pipeline, with its pose, and what its source adds to the result.
struct PreparedFrame {
  StereoFrame frame;
  Clock::time_point captured{};                  ///< live sources only: see LiveFrame
  std::optional<std::string> warning{};          ///< appended to the result's
  std::optional<PoseCovariances> covariances{};  ///< covariances of the pose; none: unknown
  std::optional<double> odometry_ms{};           ///< time of visual odometry; none: the pose came with the input
  bool resets_before{false};                     ///< Pipeline::reset() before this frame
  std::size_t recorded{0};                       ///< live sources only: see LiveFrame
};

/// Source and destination of the frames of run_frames().
class STEREOGRID_EXPORT FrameHandler {
 public:
  FrameHandler() = default;
  FrameHandler(const FrameHandler&) = delete;
  FrameHandler& operator=(const FrameHandler&) = delete;
  virtual ~FrameHandler();

  /// Next frame; none: there is none yet, or has_ended(). Throws InputError: a frame cannot be used.
  [[nodiscard]] virtual std::optional<PreparedFrame> next() = 0;
  [[nodiscard]] virtual bool has_ended() const = 0;
  /// Receives a frame and its result; both may be moved from.
  virtual void deliver(PreparedFrame& prepared, FrameResult& result) = 0;
  /// Receives the reason why the last frame could not be used: the text of the InputError of next() or the pipeline.
  virtual void refuse(const std::string& reason) = 0;
};

/// Takes frames through the pipeline until the handler has ended. Exceptions other than InputError pass.
STEREOGRID_EXPORT void run_frames(Pipeline& pipeline, FrameHandler& frames);

}  // namespace stereogrid::capture
