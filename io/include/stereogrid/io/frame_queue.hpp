// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/pose_covariances.hpp"

namespace stereogrid::io {

/// A frame of the queue, or why there is none.
struct QueuedFrame {
  std::size_t index{0};  ///< in the source
  std::string name;
  std::optional<StereoFrame> frame;      ///< none: it cannot be used
  std::string error;                     ///< then: the InputError's text
  double prepared_ms{0};                 ///< wall-clock time of the preparation
  std::optional<std::string> warning{};  ///< for the preparation to fill, as covariances
  std::optional<PoseCovariances> covariances{};
};

/// Work on a loaded frame on the background threads, called for usable frames one after the other, in order. An
/// InputError marks the frame as unusable.
using Preparation = std::function<void(QueuedFrame&)>;

/// Loads the next frames of a source on background threads while the consumer works on the ones before. Frames come out
/// in order, whatever the number of threads. next() is for one consumer.
class STEREOGRID_EXPORT FrameQueue {
 public:
  /// Frames [first, last) of the source, which must outlive the queue; at most `capacity` are loaded ahead.
  FrameQueue(const FrameSource& source, std::size_t first, std::size_t last, std::size_t capacity = 4, int threads = 1,
             Preparation prepare = {});
  FrameQueue(const FrameQueue&) = delete;
  FrameQueue& operator=(const FrameQueue&) = delete;
  /// Stops at once: waits only for frames that are being loaded at this moment.
  ~FrameQueue();

  /// Loads no more frames. False: one is still being loaded after `time`, and the destructor would wait for it.
  [[nodiscard]] bool stop_within(std::chrono::milliseconds time);

  /// Waits for the next frame, but no longer than `time`. True: next() need not wait.
  [[nodiscard]] bool is_ready_within(std::chrono::milliseconds time);

  /// The next frame; waits for it. None: the end. A frame that cannot be used comes in its place with its error;
  /// exceptions other than InputError are thrown again here.
  [[nodiscard]] std::optional<QueuedFrame> next();

 private:
  struct STEREOGRID_HIDDEN State;
  std::unique_ptr<State> state_;
};

}  // namespace stereogrid::io
