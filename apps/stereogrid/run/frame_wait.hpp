// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

#include "stereogrid/io/frame_queue.hpp"

namespace stereogrid::app {

/// Time for a frame that is being read when a stop is requested.
constexpr std::chrono::seconds stop_wait{2};

/// Waits for the next frame of the queue, the input's frame `index`, for `limit`, or `stop_wait` after a stop was
/// requested; logs a long wait, as on a lost network file system. False: it has not come.
[[nodiscard]] bool wait_for_frame(io::FrameQueue& queue, std::size_t index, std::chrono::seconds limit);

}  // namespace stereogrid::app
