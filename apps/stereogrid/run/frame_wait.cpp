// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/frame_wait.hpp"

#include <spdlog/spdlog.h>

#include <chrono>

#include "cli/interrupt.hpp"

namespace stereogrid::app {

bool wait_for_frame(io::FrameQueue& queue, std::size_t index, int limit_s) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds look_around{200};
  constexpr std::chrono::seconds long_wait{10};
  const Clock::time_point start{Clock::now()};
  bool is_told{false};
  while (!queue.is_ready_within(look_around)) {
    if (interrupted() != 0) return true;
    const auto waited{Clock::now() - start};
    if (waited >= std::chrono::seconds{limit_s}) return false;
    if (is_told || waited < long_wait) continue;
    spdlog::warn("frame {} has not come for {} s: is the input's file system slow, or gone? Ctrl-C twice ends the run",
                 index, long_wait.count());
    is_told = true;
  }
  return true;
}

}  // namespace stereogrid::app
