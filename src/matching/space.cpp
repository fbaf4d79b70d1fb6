// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>

#include "matching/census_simd.hpp"
#include "matching/correlate_simd.hpp"
#include "matching/matching.hpp"
#include "matching/semi_global.hpp"

namespace stereogrid {
MatchingSpace::MatchingSpace(int width, int height, const MatchingConfig& config, int threads)
    : left{width, height, row_overrun},
      right{width, height, row_overrun},
      sheared{width, height, row_overrun},
      textured{width, height, row_overrun},
      speckles{width, height},
      rows(static_cast<std::size_t>(threads), RowCandidates{width}),
      decisions(static_cast<std::size_t>(threads), DecideSpace{width}),
      textures(static_cast<std::size_t>(threads), TextureSpace{width, config.window_px / 2}) {
  if (config.method == MatchingMethod::semi_global) {
    for (auto* census : {&census_left, &census_right, &census_sheared}) *census = {width, height, row_overrun};
  } else {
    short_left_fourfold = {width, height, 0};
    const int border{correlate_border(upright_shifts(config), road_shifts(config))};
    for (auto* census : {&short_left, &short_right_reversed, &short_sheared}) *census = {width, height, border};
  }
}

Shifts upright_shifts(const MatchingConfig& config) {
  return {config.min_disparity, config.disparities - config.min_disparity};
}

Shifts road_shifts(const MatchingConfig& config) {
  return {-config.road_margin_px, 2 * config.road_margin_px + 1};
}

// Fitted by gradient descent on the log-loss of "right to a pixel" over the four kinds of truth that bench_accuracy
// reads (two lidar drives, two pairs, five rendered sequences; equal weight each). docs/results.md has the reliability.
ConfidenceModel confidence_model(const MatchingConfig& config) {
  if (config.method == MatchingMethod::semi_global) {
    return {1.0f / cost_max,
            {1.643f, -4.749f, -6.633f, 10.157f, -4.428f, 0.084f, -1.230f},
            {2.800f, -6.784f, -19.694f, 13.666f, 7.520f, -1.072f, -1.176f}};
  }
  const int most{compared_bits(config.window_px) * config.window_px * config.window_px};
  return {1.0f / static_cast<float>(most),
          {0.796f, -2.726f, -9.249f, 22.429f, 5.851f, 0.222f, -1.012f},
          {1.146f, -3.612f, -8.663f, 34.494f, 24.037f, 0.016f, -1.545f}};
}

int uniqueness_1024(const MatchingConfig& config) {
  return static_cast<int>(std::lround(config.uniqueness * 1024));
}

}  // namespace stereogrid
