// SPDX-License-Identifier: Apache-2.0
#include "matching/matching.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "matching/correlation/simd.hpp"

namespace stereogrid {

Shifts upright_shifts(const MatchingConfig& config) {
  return {0, config.disparities};
}

int least_texture(const MatchingConfig& config) {
  return static_cast<int>(std::ceil(config.texture * config.window_px * config.window_px));
}

SpeckleSizes speckle_sizes(const MatchingConfig& config) {
  return {config.speckle_px, config.road_speckle_px};
}

/// Share of the largest cost up to which a patch is surely similar to its counterpart: real surfaces cost .10 to .37.
/// Above .2, occluded bands of the lidar drives become ambiguous.
constexpr double ambiguous_cost_share{0.2};

// Fitted by gradient descent on the log-loss of "right to a pixel" over the four kinds of truth that a benchmark
// reads (two lidar drives, two pairs, five rendered sequences; equal weight each), matches of the whole pipeline.
ConfidenceModel confidence_model(const MatchingConfig& config) {
  const int most{compared_bits(config.window_px) * config.window_px * config.window_px};
  const int limit{static_cast<int>(config.cost_limit * most)};
  return {limit,
          std::min(limit, static_cast<int>(ambiguous_cost_share * most)),
          1.0f / static_cast<float>(most),
          {1.057f, -2.645f, -6.135f, 20.821f, 0.743f, 0.121f, -0.741f},
          {0.060f, -2.173f, -3.143f, 61.630f, 33.120f, 1.446f, -1.529f}};
}

bool has_tops(const MatchingConfig& config) {
  return config.thin_tops;
}

TopRules top_rules(const MatchingConfig& config) {
  const double most{static_cast<double>(compared_bits(config.window_px) * top_samples)};
  return {confidence_model(config), config.disparities, static_cast<int>(ambiguous_cost_share * most),
          config.window_px * config.window_px, config.subpixel};
}

int uniqueness_1024(const MatchingConfig& config) {
  return static_cast<int>(std::lround(config.uniqueness * 1024));
}

MatchingWorkspace::MatchingWorkspace(int width, int height, const MatchingConfig& config, int threads)
    : left{width, height, row_overrun},
      right{width, height, row_overrun},
      sheared{width, height, row_overrun},
      textured{width, height, row_overrun},
      speckles{width, height, threads},
      rows(static_cast<std::size_t>(threads), RowCandidates{width}),
      decisions(static_cast<std::size_t>(threads), ClassifyWorkspace{width}),
      textures(static_cast<std::size_t>(threads), TextureWorkspace{width, config.window_px / 2}) {
  if (has_tops(config)) tops = {top_columns(width), top_row_pairs(height)};
  const int border{correlate_border(upright_shifts(config))};
  for (auto* census : {&short_left, &short_right_reversed, &short_sheared}) *census = {width, height, border};
}

}  // namespace stereogrid
