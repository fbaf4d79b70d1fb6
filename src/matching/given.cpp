// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/given.hpp"

#include <algorithm>
#include <cmath>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};
constexpr double significance{2};  // standard deviations
constexpr PlaneSigmas fitted{0.02, 0.001, 0.003};
constexpr PlaneSigmas predicted{0.05, 0.005, 0.01};

// Bin 0 is "no measurement", and the u-disparity plane ends.
bool is_usable(float disparity, const MatchingConfig& config) {
  return disparity >= 0.5f && disparity < static_cast<float>(config.disparities) - 0.5f;
}

void split_row(int v, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
               Matches& matches) {
  const RoadPlane plane{road_plane(rig, ground)};
  const PlaneSigmas sigmas{plane_sigmas(ground)};
  for (int u{0}; u < disparity.width; ++u) {
    const float d{disparity(u, v)};
    float road{0};
    float obstacle{0};
    if (is_usable(d, config)) {
      const RoadBand band{road_band(rig, ground.height_m, sigmas, config, u, plane.disparity(u, v))};
      if (d > band.high) {
        obstacle = d;
      } else if (d >= band.low) {
        road = d;
      }
    }
    matches.road(u, v) = road;
    matches.obstacle(u, v) = obstacle;
  }
}

}  // namespace

PlaneSigmas plane_sigmas(const Ground& ground) {
  return ground.estimated ? fitted : predicted;
}

RoadBand road_band(const Rig& rig, double ground_height_m, const PlaneSigmas& sigmas, const MatchingConfig& config,
                   double u, double road_disparity) {
  const double scale{rig.baseline_m / ground_height_m};
  const double by_height{road_disparity * sigmas.height_m / ground_height_m};
  const double by_pitch{scale * rig.focal_px * sigmas.pitch_rad};
  const double by_roll{scale * (u - rig.centre_u_px) * sigmas.roll_rad};
  const double variance{config.given_sigma_px * config.given_sigma_px + by_height * by_height + by_pitch * by_pitch +
                        by_roll * by_roll};
  const double noise{significance * std::sqrt(variance)};
  // d = d_r/(1 − h/H); no pixel above the horizon is at the height of the road
  const double share{config.given_height_m / ground_height_m};
  const double d{std::max(road_disparity, 0.0)};
  return {std::min(d / (1 + share), road_disparity - noise),
          std::max(share < 1 ? d / (1 - share) : HUGE_VAL, road_disparity + noise)};
}

void split(Cpu& cpu, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  cpu.for_ranges(disparity.height, rows_grain, [&](int begin, int end) {
    for (int v{begin}; v < end; ++v) split_row(v, disparity, rig, ground, config, matches);
  });
}

void split(Reference&, View<const float> disparity, const Rig& rig, const Ground& ground, const MatchingConfig& config,
           Matches& matches) {
  for (int v{0}; v < disparity.height; ++v) split_row(v, disparity, rig, ground, config, matches);
}

void leave_whole(View<const float> disparity, const MatchingConfig& config, Matches& matches) {
  matches.road.fill(0);
  for (int v{0}; v < disparity.height; ++v) {
    std::transform(disparity.row(v), disparity.row(v) + disparity.width, matches.obstacle.row(v),
                   [&](float d) { return is_usable(d, config) ? d : 0.0f; });
  }
}

}  // namespace stereogrid
