// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "stereogrid/frame.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Frames that a thread works on one after the other while the caller goes on.
class FramesInFlight {
 public:
  static constexpr std::size_t frames_max{2};

  /// `work` is called in the thread.
  explicit FramesInFlight(std::function<void(const StereoFrame&, FrameResult&)> work);
  FramesInFlight(const FramesInFlight&) = delete;
  FramesInFlight& operator=(const FramesInFlight&) = delete;
  /// Waits for the frame in work; others are dropped.
  ~FramesInFlight();

  [[nodiscard]] std::size_t size() const { return submitted_ - collected_; }
  /// Fewer than frames_max must be in flight.
  void submit(StereoFrame frame);
  /// Waits for the oldest one and rethrows what `work` threw. At least one must be in flight. The result changes with
  /// the next call.
  const FrameResult& collect();
  struct Waiting {
    const StereoFrame& frame;
    FrameResult& result;
  };
  /// For `work`: the frame behind the one in work, if it is there. It stays until it has been worked on.
  [[nodiscard]] std::optional<Waiting> next();
  [[nodiscard]] std::size_t held_bytes() const;

 private:
  struct Slot {
    StereoFrame frame;
    FrameResult result;
    std::exception_ptr error;
  };

  void keep_working();
  Slot& slot_of(std::size_t frame) { return slots_[frame % slots_.size()]; }

  std::function<void(const StereoFrame&, FrameResult&)> work_;
  std::array<Slot, frames_max + 1> slots_;  ///< one more: the caller still reads the result collected last
  std::size_t submitted_{0};
  std::size_t collected_{0};
  std::size_t worked_on_{0};
  bool is_over_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
};

}  // namespace stereogrid
