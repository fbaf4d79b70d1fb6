// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include <functional>
#include <optional>
#include <string>

#include "stereogrid/capture/camera_pair.hpp"

namespace stereogrid::capture::testing {

using namespace std::chrono_literals;

constexpr int width_px{32};
constexpr int height_px{16};

/// A rectified pair of small images.
[[nodiscard]] io::Calibration small_calibration();
/// All pixels alike.
[[nodiscard]] Image<std::uint8_t> plain(std::uint8_t level, int width = width_px, int height = height_px);
[[nodiscard]] PixelView view(const Image<std::uint8_t>& image);

/// The next frame, for which it waits 10 s at most.
[[nodiscard]] std::optional<LiveFrame> wait_for_frame(LiveSource& source);
/// Whether it becomes true within 20 s.
[[nodiscard]] bool becomes(const std::function<bool()>& is_true);
[[nodiscard]] std::int64_t dropped(const LiveSource& source, const std::string& reason);

}  // namespace stereogrid::capture::testing
