// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../prelude.hpp"
#include "stereogrid/capture/camera_pair.hpp"

namespace stereogrid::capture::testing {

using namespace std::chrono_literals;

constexpr int width_px{32};
constexpr int height_px{16};

/// A rectified pair of small images.
[[nodiscard]] inline io::Calibration small_calibration() {
  io::Calibration calibration;
  calibration.rig = {.width_px = width_px,
                     .height_px = height_px,
                     .focal_px = 30,
                     .cx_px = 15.5,
                     .cy_px = 7.5,
                     .baseline_m = 0.1,
                     .camera_height_m = 1};
  return calibration;
}

/// All pixels alike.
[[nodiscard]] inline Image<std::uint8_t> plain(std::uint8_t level, int width = width_px, int height = height_px) {
  return Image<std::uint8_t>{width, height, level};
}

[[nodiscard]] inline PixelView view(const Image<std::uint8_t>& image) {
  return {image.data(), image.width(), image.height()};
}

/// The next frame, for which it waits 10 s at most.
[[nodiscard]] inline std::optional<LiveFrame> wait_for_frame(LiveSource& source) {
  const auto until{Clock::now() + 10s};
  while (Clock::now() < until && !source.has_ended()) {
    if (auto frame{source.next(100ms)}) return frame;
  }
  return std::nullopt;
}

/// Whether it becomes true within 20 s.
[[nodiscard]] inline bool becomes(const std::function<bool()>& is_true) {
  const auto until{Clock::now() + 20s};
  while (Clock::now() < until) {
    if (is_true()) return true;
    std::this_thread::sleep_for(10ms);
  }
  return false;
}

[[nodiscard]] inline std::int64_t dropped(const LiveSource& source, const std::string& reason) {
  for (const Drop& drop : source.dropped()) {
    if (drop.reason == reason) return drop.frames;
  }
  return 0;
}

}  // namespace stereogrid::capture::testing
