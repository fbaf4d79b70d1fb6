// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/frame_wait.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "cli/console.hpp"

namespace stereogrid::app {

bool wait_for_frame(io::FrameQueue& queue, std::size_t index, std::chrono::seconds limit) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds look_around{200};
  constexpr std::chrono::seconds long_wait{10};
  const Clock::time_point start{Clock::now()};
  Clock::time_point end{start + limit};
  bool is_told{false};
  bool is_stopped{false};
  while (!queue.is_ready_within(look_around)) {
    const Clock::time_point now{Clock::now()};
    if (interrupted() != 0 && !std::exchange(is_stopped, true)) end = std::min(end, now + stop_wait);
    if (now >= end) return false;
    if (is_told || now < start + long_wait) continue;
    spdlog::warn("frame {} has not come for {} s: is the input's file system slow, or gone? Ctrl-C ends the run", index,
                 long_wait.count());
    is_told = true;
  }
  return true;
}

}  // namespace stereogrid::app
