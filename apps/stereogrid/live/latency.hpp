// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "stereogrid/messages/frame_messages.hpp"

namespace stereogrid::app {

/// Latencies of the last frames.
class LatencyWindow {
 public:
  /// With the newest one.
  [[nodiscard]] messages::Latency add(std::chrono::nanoseconds latency);

 private:
  static constexpr std::size_t kept{1000};

  std::vector<double> last_ms_;  // ring buffer when full
  std::size_t next_{0};
  std::vector<double> sorted_;
};

}  // namespace stereogrid::app
