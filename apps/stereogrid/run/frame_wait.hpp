// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "stereogrid/io/frame_queue.hpp"

namespace stereogrid::app {

/// Waits for the next frame of the queue, the input's frame `index`; logs a long wait, as on a lost network file
/// system. True: the frame is available, or a stop was requested. False: not within `limit_s`.
[[nodiscard]] bool wait_for_frame(io::FrameQueue& queue, std::size_t index, int limit_s);

}  // namespace stereogrid::app
