// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/external.hpp"

#include <algorithm>

#include "backend/cpu.hpp"
#include "backend/reference.hpp"

namespace stereogrid {
namespace {

constexpr int rows_grain{32};
void split_row(int v, View<const float> disparity, const RoadPlane& plane, const HeightTest& test,
               const MatchingConfig& config, Matches& matches) {
  const SplitRow row{plane, v};
  for (int u{0}; u < disparity.width; ++u) {
    const SplitDisparity parts{row.at(u, disparity(u, v), test, config.disparities)};
    matches.obstacle(u, v) = parts.obstacle;
    matches.road(u, v) = parts.road;
  }
}

}  // namespace

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
                   [&](float d) { return is_usable(d, config.disparities) ? d : 0.0f; });
  }
}

}  // namespace stereogrid
