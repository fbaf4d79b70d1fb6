// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace stereogrid {

/// About half a matching window: pixels so near an edge of depth …
constexpr int edge_reach_px{5};
/// … that lie between both surfaces by more than this belong to neither.
constexpr float edge_step_px{1.2f};

/// Which disparities of an image row are those of something that stands on the ground.
struct UprightRow {
  float nearest_px;
  float farthest_px;
  float road_px;        ///< of the road, in column 0
  float road_per_px;    ///< and how it changes from column to column
  float lowest_share;   ///< of a disparity: the road's behind what is just high enough, …
  float highest_share;  ///< … and behind what is as high as an obstacle may be

  [[nodiscard]] float road(int u) const { return road_px + road_per_px * static_cast<float>(u); }
  [[nodiscard]] bool is_upright(int u, float d) const {
    return d > farthest_px && d < nearest_px && road(u) <= lowest_share * d;
  }
  [[nodiscard]] bool is_below_highest(int u, float d) const { return road(u) > highest_share * d; }
};

/// Pixels of a part of a row.
struct UprightPixels {
  static constexpr int most{256};

  int size{0};
  std::int32_t columns[most];  // NOLINT(modernize-avoid-c-arrays): not set to 0 for each part
  float disparities[most];     // NOLINT(modernize-avoid-c-arrays)
};

/// Of the columns `begin` … `end` − 1, UprightPixels::most at most, of a row of `width` disparities (px, 0 = none),
/// what is upright, by column; without pixels that have, within edge_reach_px, both a disparity larger and one smaller
/// than theirs by more than edge_step_px.
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);

/// The same in plain loops: the definition.
namespace plain {
void find_upright(const float* row, int width, int begin, int end, const UprightRow& limits, UprightPixels& pixels);
}

}  // namespace stereogrid
