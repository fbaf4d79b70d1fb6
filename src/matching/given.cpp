// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/given.hpp"

#include <algorithm>
#include <limits>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};
constexpr double significance{2};  // standard deviations

// Bin 0 is "no measurement", and the u-disparity plane ends.
bool is_usable(float disparity, const MatchingConfig& config) {
  return disparity >= 0.5f && disparity < static_cast<float>(config.disparities) - 0.5f;
}

void split_row(int v, View<const float> disparity, const RoadPlane& plane, const HeightTest& test,
               const MatchingConfig& config, Matches& matches) {
  const auto centre_u{static_cast<float>(plane.centre_u_px)};
  const auto per_u{static_cast<float>(plane.per_u)};
  const auto at_centre{static_cast<float>(plane.disparity(plane.centre_u_px, v))};
  for (int u{0}; u < disparity.width; ++u) {
    const float d{disparity(u, v)};
    const float x{static_cast<float>(u) - centre_u};
    const float r{at_centre + per_u * x};
    const bool usable{is_usable(d, config)};
    const bool above{test.is_above(d, r, x)};
    matches.obstacle(u, v) = usable && above ? d : 0.0f;
    matches.road(u, v) = usable && !above && !test.is_below(d, r, x) ? d : 0.0f;
  }
}

}  // namespace

HeightTest::HeightTest(const Rig& rig, const Ground& ground, const MatchingConfig& config) {
  const auto squared = [](double deviation) {
    return static_cast<float>(significance * deviation * significance * deviation);
  };
  const double scale{rig.baseline_m / ground.height_m};
  const double share{config.given_height_m / ground.height_m};
  constant = squared(config.given_sigma_px) + squared(scale * rig.focal_px * ground.pitch_sigma_rad);
  per_r2 = squared(ground.height_sigma_m / ground.height_m);
  per_x2 = squared(scale * ground.roll_sigma_rad);
  above = share < 1 ? static_cast<float>(1 / (1 - share)) : std::numeric_limits<float>::infinity();
  below = static_cast<float>(1 / (1 + share));
}

void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  const RoadPlane plane{road_plane(rig, ground)};
  const HeightTest test{rig, ground, config};
  cpu.for_ranges(disparity.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) split_row(v, disparity, plane, test, config, matches);
  });
}

void split(Reference&, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  const RoadPlane plane{road_plane(rig, ground)};
  const HeightTest test{rig, ground, config};
  for (int v{0}; v < disparity.height; ++v) split_row(v, disparity, plane, test, config, matches);
}

void leave_whole(View<const float> disparity, const MatchingConfig& config, Matches& matches) {
  matches.road.fill(0);
  for (int v{0}; v < disparity.height; ++v) {
    std::transform(disparity.row(v), disparity.row(v) + disparity.width, matches.obstacle.row(v),
                   [&](float d) { return is_usable(d, config) ? d : 0.0f; });
  }
}

}  // namespace stereogrid
