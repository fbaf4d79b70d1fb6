// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>

#include "stereogrid/capture/live_source.hpp"

namespace stereogrid::capture {

/// Turns this process's clock into Unix time; by the same offset always, so that a clock that is set does not reorder
/// frames.
class UnixTime {
 public:
  [[nodiscard]] std::int64_t ns(Clock::time_point instant) const { return offset_ns_ + nanoseconds(instant); }

 private:
  template <class T>
  static std::int64_t nanoseconds(T instant) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(instant.time_since_epoch()).count();
  }

  std::int64_t offset_ns_{nanoseconds(std::chrono::system_clock::now()) - nanoseconds(Clock::now())};
};

}  // namespace stereogrid::capture
