// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

#include "matching/matching.hpp"
#include "matching/semi_global.hpp"

namespace stereogrid {
namespace {

template <class T>
T at_clamped(View<const T> image, int u, int v) {
  return image(std::clamp(u, 0, image.width - 1), std::clamp(v, 0, image.height - 1));
}

void census_image(View<const std::uint8_t> grey, View<std::uint32_t> descriptors) {
  for (int v{0}; v < grey.height; ++v) {
    for (int u{0}; u < grey.width; ++u) {
      descriptors(u, v) = census([&](int i, int j) { return at_clamped(grey, u + i, v + j); });
    }
  }
}

int window_cost(View<const std::uint32_t> left, View<const std::uint32_t> right, int u, int v, int shift, int half) {
  int sum{0};
  for (int j{-half}; j <= half; ++j) {
    for (int i{-half}; i <= half; ++i) {
      // the window's pixels outside the left image repeat the border; so do the right image's
      const int column{std::clamp(u + i, 0, left.width - 1)};
      sum += std::popcount(at_clamped(left, column, v + j) ^ at_clamped(right, column - shift, v + j));
    }
  }
  return sum;
}

// argmin over the shifts for which the right pixel sees a left pixel of this image
int best_shift_of_right(const std::vector<int>& costs_of_row, int width, Shifts shifts, int right_u) {
  int best{-1};
  int best_cost{0};
  for (int k{0}; k < shifts.count; ++k) {
    const int u{right_u + shifts.first + k};
    if (u < 0 || u >= width) continue;
    const int cost{costs_of_row[static_cast<std::size_t>(u * shifts.count + k)]};
    if (best < 0 || cost < best_cost) {
      best = k;
      best_cost = cost;
    }
  }
  return shifts.first + best;
}

Candidate candidate_of(const int* costs, Shifts shifts) {
  const int best{static_cast<int>(std::min_element(costs, costs + shifts.count) - costs)};
  int runner_up{65535};
  for (int k{0}; k < shifts.count; ++k) {
    if (std::abs(k - best) > 1) runner_up = std::min(runner_up, costs[k]);
  }
  const bool inside{best > 0 && best < shifts.count - 1};
  return {static_cast<std::uint16_t>(costs[best]), static_cast<std::uint16_t>(runner_up),
          static_cast<std::int16_t>(shifts.first + best), false,
          inside ? subpixel_offset(costs[best - 1], costs[best], costs[best + 1]) : 0.0f};
}

bool is_textured(View<const std::uint8_t> left, int u, int v, const MatchingConfig& config) {
  const int half{config.window_px / 2};
  int sum{0};
  for (int j{-half}; j <= half; ++j) {
    for (int i{-half}; i <= half; ++i) {
      const int column{std::clamp(u + i, 0, left.width - 1)};
      sum += std::abs(at_clamped(left, column + 1, v + j) - at_clamped(left, column - 1, v + j));
    }
  }
  return sum >= config.texture * config.window_px * config.window_px;
}

}  // namespace

void correlate(Reference&, View<const std::uint32_t> left, View<const std::uint32_t> right, Shifts shifts,
               const MatchingConfig& config, View<Candidate> candidates) {
  const int width{left.width};
  std::vector<int> costs(static_cast<std::size_t>(width * shifts.count));
  for (int v{0}; v < left.height; ++v) {
    for (int u{0}; u < width; ++u) {
      int* curve{&costs[static_cast<std::size_t>(u * shifts.count)]};
      for (int k{0}; k < shifts.count; ++k) {
        curve[k] = window_cost(left, right, u, v, shifts.first + k, config.window_px / 2);
      }
      candidates(u, v) = candidate_of(curve, shifts);
    }
    for (int u{0}; u < width; ++u) {
      Candidate& candidate{candidates(u, v)};
      const int right_u{u - candidate.shift};
      candidate.consistent =
          right_u >= 0 && right_u < width &&
          std::abs(best_shift_of_right(costs, width, shifts, right_u) - candidate.shift) <= config.left_right_px;
    }
  }
}

void match(Reference& reference, View<const std::uint8_t> left, View<const std::uint8_t> right, const RoadPlane& plane,
           const MatchingConfig& config, MatchingSpace& space, Matches& matches) {
  for (int v{0}; v < left.height; ++v) {
    for (int u{0}; u < left.width; ++u) {
      space.sheared_right(u, v) = sheared(right.row(v), left.width, u, shear_of(plane.disparity(u, v)));
      space.textured(u, v) = is_textured(left, u, v, config) ? 1 : 0;
    }
  }
  census_image(left, space.census_left.view());
  census_image(right, space.census_right.view());
  census_image(space.sheared_right.view(), space.census_sheared.view());
  const CensusTriple census{space.census_left.view(), space.census_right.view(), space.census_sheared.view()};
  if (config.method == MatchingMethod::semi_global) {
    optimise(reference, census, plane, config, space.upright.view(), space.level.view());
  } else {
    correlate(reference, census.left, census.right, upright_shifts(config), config, space.upright.view());
    correlate(reference, census.left, census.sheared, road_shifts(config), config, space.level.view());
  }
  for (int v{0}; v < left.height; ++v) decide_row(v, plane, config, space, matches);
  remove_speckles(config.speckle_px, space.patch, matches);
}

}  // namespace stereogrid
