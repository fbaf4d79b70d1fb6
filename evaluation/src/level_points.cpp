// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "level_points.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "stereogrid/level_mapping.hpp"

namespace stereogrid::evaluation {

LevelFrame::LevelFrame(const Rig& rig) : rig_{rig} {
  const double turned_rad{LevelMapping{rig}.is_identity() ? 0 : rig.camera_pitch_rad};
  sin_ = std::sin(turned_rad);
  cos_ = std::cos(turned_rad);
}

std::vector<CameraPoint> LevelFrame::operator()(std::span<const CameraPoint> points) const {
  std::vector<CameraPoint> level;
  level.reserve(points.size());
  std::ranges::transform(points, std::back_inserter(level),
                         [this](const CameraPoint& point) { return (*this)(point); });
  return level;
}

// g·X = height, with g the unit vector to the road (docs/method.md §1.2).
RoadPlane LevelFrame::road(double camera_height_m) const {
  const double cos_pitch{std::cos(rig_.camera_pitch_rad)};
  const CameraPoint g{(*this)({cos_pitch * std::sin(rig_.camera_roll_rad), cos_pitch * std::cos(rig_.camera_roll_rad),
                               std::sin(rig_.camera_pitch_rad)})};
  return {-g.x_m / g.y_m, -g.z_m / g.y_m, camera_height_m / g.y_m};
}

}  // namespace stereogrid::evaluation
