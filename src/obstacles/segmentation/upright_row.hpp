// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace stereogrid {

/// About half a matching window. Pixels within this distance of a depth edge …
constexpr int edge_reach_px{5};
/// … that differ from both of its surfaces by more than this belong to neither.
constexpr float edge_step_px{1.2f};

/// Limits of the disparities of obstacles in an image row.
struct UprightRow {
  float nearest_px;
  float farthest_px;
  float road_px;        ///< disparity of the road in column 0
  float road_per_px;    ///< change of the road's disparity per column
  float lowest_share;   ///< maximum ratio of the road's disparity to a pixel's, for the minimum obstacle height
  float highest_share;  ///< its minimum, for the maximum obstacle height

  [[nodiscard]] float road(int u) const { return road_px + road_per_px * static_cast<float>(u); }
  [[nodiscard]] bool is_upright(int u, float d) const {
    return d > farthest_px && d < nearest_px && road(u) <= lowest_share * d;
  }
  [[nodiscard]] bool is_below_highest(int u, float d) const { return road(u) > highest_share * d; }
};

struct UprightPixels {
  static constexpr int most{256};

  int size{0};
  std::int32_t columns[most];  // NOLINT(modernize-avoid-c-arrays): not set to 0 for each part
  float disparities[most];     // NOLINT(modernize-avoid-c-arrays)
};

/// Obstacle pixels in the columns `begin` … `end` − 1 (UprightPixels::most at most) of a row of `width` disparities
/// (px, 0 = none). Excludes pixels that have, within edge_reach_px, both a larger and a smaller disparity by more than
/// edge_step_px.
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);

/// The same in plain loops: the definition.
namespace plain {
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);
}

}  // namespace stereogrid
