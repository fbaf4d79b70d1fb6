// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>

#include "matching/census_simd.hpp"
#include "matching/correlate_simd.hpp"
#include "matching/matching.hpp"

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
  return {0, config.disparities};
}

Shifts road_shifts(const MatchingConfig& config) {
  return {-config.road_margin_px, 2 * config.road_margin_px + 1};
}

// Fitted by gradient descent on the log-loss of "right to a pixel" over the four kinds of truth that bench_accuracy
// reads (two lidar drives, two pairs, five rendered sequences; equal weight each). docs/results.md has the reliability.
ConfidenceModel confidence_model(const MatchingConfig& config) {
  if (config.method == MatchingMethod::semi_global) {
    return {1.0f / 255, {1.879f, -4.865f, 0.802f, -0.244f, -1.589f}, {1.975f, -6.243f, 0.846f, 1.791f, -3.256f}};
  }
  const int most{compared_bits(config.window_px) * config.window_px * config.window_px};
  return {1.0f / static_cast<float>(most),
          {1.107f, -2.994f, 1.269f, 0.502f, -1.293f},
          {1.629f, -3.957f, 1.952f, 2.527f, -2.805f}};
}

int uniqueness_1024(const MatchingConfig& config) {
  return static_cast<int>(std::lround(config.uniqueness * 1024));
}

}  // namespace stereogrid
