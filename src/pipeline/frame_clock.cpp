// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_clock.hpp"

#include <array>
#include <cstdio>
#include <utility>

namespace stereogrid {
namespace {

constexpr const char* consequence{"all state is reset"};

// Unsigned, since from one end of the stamps to the other is more than a signed number holds.
double seconds_between(std::int64_t earlier_ns, std::int64_t later_ns) {
  return static_cast<double>(static_cast<std::uint64_t>(later_ns) - static_cast<std::uint64_t>(earlier_ns)) * 1e-9;
}

std::string text_of(double seconds) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f s", seconds);
  return text.data();
}

}  // namespace

FrameClock::Tick FrameClock::tick(std::int64_t stamp_ns) {
  const std::optional<std::int64_t> last_ns{std::exchange(last_ns_, stamp_ns)};
  if (!last_ns) return {};
  if (stamp_ns < *last_ns) {
    return {0, FrameStatus::clock_stepped_back,
            "the clock has stepped back by " + text_of(seconds_between(stamp_ns, *last_ns)) + ": " + consequence};
  }
  const double dt_s{seconds_between(*last_ns, stamp_ns)};
  if (dt_s <= gap_max_s_) return {dt_s, {}, {}};
  return {0, FrameStatus::clock_gap,
          text_of(dt_s) + " since the frame before, more than motion.gap_max_s: " + consequence};
}

}  // namespace stereogrid
