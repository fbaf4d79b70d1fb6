// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "live/latency.hpp"

#include <algorithm>

namespace stereogrid::app {

messages::Latency LatencyWindow::add(std::chrono::nanoseconds latency) {
  const double now_ms{std::chrono::duration<double, std::milli>{latency}.count()};
  if (last_ms_.size() < kept) {
    last_ms_.push_back(now_ms);
  } else {
    last_ms_[next_] = now_ms;
    next_ = (next_ + 1) % kept;
  }
  sorted_ = last_ms_;
  std::ranges::sort(sorted_);
  const std::size_t last{sorted_.size() - 1};
  return {now_ms, sorted_[last / 2], sorted_[last * 99 / 100]};
}

}  // namespace stereogrid::app
