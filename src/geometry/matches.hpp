// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Obstacle disparity of an ambiguous pixel: its textured patch is surely in the right image, but in several places or
/// where another pixel matches better. Equal to 0, none.
constexpr float ambiguous_px{-0.0f};

STEREOGRID_HD inline bool is_ambiguous(float obstacle) {
  std::uint32_t bits{0};
  std::memcpy(&bits, &obstacle, sizeof(bits));
  return bits == 1U << 31;
}

/// Result of `match`: two disparity images (px, 0 = none); no pixel has both.
struct Matches {
  Matches(int width, int height) : obstacle{width, height}, road{width, height}, confidence{width, height} {}

  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(obstacle, road, confidence); }

  Image<float> obstacle;
  Image<float> road;
  Image<float> confidence;  ///< probability in [0, 1] that the disparity is right to a pixel; 0 where there is none
};

}  // namespace stereogrid
