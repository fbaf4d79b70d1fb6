// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "stereogrid/result.hpp"

namespace stereogrid {

/// The time from frame to frame, from their stamps, and what to make of a clock that leaps. Decision 19.
class FrameClock {
 public:
  explicit FrameClock(double gap_max_s) : gap_max_s_{gap_max_s} {}

  struct Tick {
    double dt_s{0};                     ///< 0: this frame is a first one
    std::optional<FrameStatus> leap{};  ///< clock_gap or clock_stepped_back: reset the state
    std::string warning{};              ///< message for the leap
  };
  /// True for the stamp of the frame before.
  [[nodiscard]] bool stands_still(std::int64_t stamp_ns) const { return last_ns_ && *last_ns_ == stamp_ns; }
  /// Advances to the next frame.
  Tick tick(std::int64_t stamp_ns);
  /// The next frame is a first one, whatever its stamp.
  void reset() { last_ns_.reset(); }

  template <class State>
  void exchange(State& state) {
    state(last_ns_);
  }

 private:
  double gap_max_s_;
  std::optional<std::int64_t> last_ns_;
};

}  // namespace stereogrid
