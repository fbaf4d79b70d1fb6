// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>

#include "matching/census_simd.hpp"
#include "matching/correlate_simd.hpp"
#include "matching/matching.hpp"

namespace stereogrid {
namespace {

int find_root(int* parent, int pixel) {
  while (parent[pixel] >= 0) {
    if (parent[parent[pixel]] >= 0) parent[pixel] = parent[parent[pixel]];
    pixel = parent[pixel];
  }
  return pixel;
}

// A root holds minus the size of its patch.
void join(int* parent, int a, int b) {
  a = find_root(parent, a);
  b = find_root(parent, b);
  if (a == b) return;
  if (parent[a] > parent[b]) std::swap(a, b);
  parent[a] += parent[b];
  parent[b] = a;
}

bool same_surface(float a, float b) {
  return a > 0 && b > 0 && std::abs(a - b) <= 1.0f;
}

}  // namespace

MatchingSpace::MatchingSpace(int width, int height, const MatchingConfig& config, int threads)
    : left{width, height, row_overrun},
      right{width, height, row_overrun},
      sheared{width, height, row_overrun},
      textured{width, height, row_overrun},
      patch{width, height},
      rows(static_cast<std::size_t>(threads), RowCandidates{width}),
      decisions(static_cast<std::size_t>(threads), DecideSpace{width}) {
  if (config.method == MatchingMethod::semi_global) {
    for (auto* census : {&census_left, &census_right, &census_sheared}) *census = {width, height, row_overrun};
  } else {
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

int uniqueness_1024(const MatchingConfig& config) {
  return static_cast<int>(std::lround(config.uniqueness * 1024));
}

void remove_speckles(int speckle_px, Image<int>& patch, Matches& matches) {
  if (speckle_px <= 1) return;
  const int width{matches.road.width()};
  int* parent{patch.data()};
  const float* images[]{matches.road.data(), matches.obstacle.data()};
  patch.fill(-1);
  for (int v{0}; v < matches.road.height(); ++v) {
    for (int u{0}; u < width; ++u) {
      const int here{v * width + u};
      for (const float* image : images) {
        if (u > 0 && same_surface(image[here], image[here - 1])) join(parent, here, here - 1);
        if (v > 0 && same_surface(image[here], image[here - width])) join(parent, here, here - width);
      }
    }
  }
  for (std::size_t pixel{0}; pixel < patch.size(); ++pixel) {
    const int size{-parent[find_root(parent, static_cast<int>(pixel))]};
    if (size >= speckle_px) continue;
    matches.road.data()[pixel] = 0;
    matches.obstacle.data()[pixel] = 0;
  }
}

}  // namespace stereogrid
