// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "stereogrid/frame.hpp"
#include "support.hpp"

namespace stereogrid::test {

/// The vehicle's own bonnet in every frame of both cameras: an upright, textured surface below an arched line.
struct Bonnet {
  int top_row;       ///< highest image row of the bonnet
  double disparity;  ///< px
  int arch_px{6};    ///< difference to its row at the image's sides

  [[nodiscard]] bool covers(int u, int v, int width) const {
    const double x{(2.0 * u - width) / width};
    return v >= top_row + arch_px * x * x;
  }

  void paint(StereoFrame& frame) const {
    const Texture texture{91};
    const int width{frame.left.width()};
    for (int v{top_row}; v < frame.left.height(); ++v) {
      for (int u{0}; u < width; ++u) {
        if (covers(u, v, width)) frame.left(u, v) = static_cast<std::uint8_t>(texture.at(u, v));
        const double in_left{u + disparity};
        if (covers(static_cast<int>(std::lround(in_left)), v, width)) {
          frame.right(u, v) = static_cast<std::uint8_t>(texture.at(in_left, v));
        }
      }
    }
  }

  /// PipelineOptions::mask, which leaves a margin.
  [[nodiscard]] Image<std::uint8_t> mask(int width, int height, int margin_px) const {
    Image<std::uint8_t> mask{width, height, 255};
    for (int v{0}; v < height; ++v) {
      for (int u{0}; u < width; ++u) mask(u, v) = covers(u, v + margin_px, width) ? 0 : 255;
    }
    return mask;
  }
};

}  // namespace stereogrid::test
