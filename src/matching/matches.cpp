// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>

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

MatchingSpace::MatchingSpace(int width, int height)
    : sheared_right{width, height},
      census_left{width, height},
      census_right{width, height},
      census_sheared{width, height},
      upright{width, height},
      level{width, height},
      textured{width, height},
      patch{width, height} {}

Shifts upright_shifts(const MatchingConfig& config) {
  return {0, config.disparities};
}

Shifts road_shifts(const MatchingConfig& config) {
  return {-config.road_margin_px, 2 * config.road_margin_px + 1};
}

void decide_row(int v, const RoadPlane& plane, const MatchingConfig& config, const MatchingSpace& space,
                Matches& matches) {
  const int uniqueness{static_cast<int>(std::lround(config.uniqueness * 1024))};
  const auto accepted = [&](const Candidate& candidate) {
    return candidate.consistent && is_unique(candidate.cost, candidate.runner_up, uniqueness);
  };
  for (int u{0}; u < matches.road.width(); ++u) {
    const Candidate& upright{space.upright(u, v)};
    const Candidate& level{space.level(u, v)};
    const double road_disparity{plane.disparity(u, v)};
    const bool is_road{road_disparity >= 1 && level.cost < upright.cost};
    float road{0};
    float obstacle{0};
    if (space.textured(u, v) != 0) {
      const float level_offset{config.subpixel ? level.offset : 0.0f};
      const float upright_offset{config.subpixel ? upright.offset : 0.0f};
      const float on_road{static_cast<float>(road_disparity) + static_cast<float>(level.shift) + level_offset};
      if (is_road && accepted(level) && on_road >= 0.5f && on_road < static_cast<float>(config.disparities) - 0.5f) {
        road = on_road;
      }
      if (!is_road && upright.shift > 0 && accepted(upright)) {
        obstacle = static_cast<float>(upright.shift) + upright_offset;
      }
    }
    matches.road(u, v) = road;
    matches.obstacle(u, v) = obstacle;
  }
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
