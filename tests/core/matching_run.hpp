// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "backend/cpu.hpp"
#include "backend/reference.hpp"
#include "matching/matching.hpp"

namespace stereogrid::test {

/// Every test of a match that can be switched off is off; left-right stays on.
inline MatchingConfig permissive_config() {
  MatchingConfig config;
  config.disparities = 32;
  config.window_px = 9;
  config.road_margin_px = 3;
  config.uniqueness = 0;
  config.texture = 0;
  config.left_right_px = 1;
  config.speckle_px = 0;
  config.subpixel = true;
  return config;
}

/// No road anywhere in the image.
constexpr RoadPlane no_road{-1000, 0, 0, 0, 0};

struct MatchRun {
  template <class BackEndType>
  MatchRun(BackEndType& back_end, const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
           const RoadPlane& plane, const MatchingConfig& config)
      : space{left.width(), left.height()}, matches{left.width(), left.height()} {
    matches.road.fill(-7);
    matches.obstacle.fill(-7);
    match(back_end, left.view(), right.view(), plane, config, space, matches);
  }

  MatchingSpace space;
  Matches matches;
};

}  // namespace stereogrid::test
