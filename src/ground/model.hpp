// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "host_device.hpp"
#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Disparity of the road at a pixel: at_centre + per_u·(u − u0) + per_v·(v − v0), in px.
struct RoadPlane {
  double at_centre{0};
  double per_u{0};
  double per_v{0};
  double centre_u_px{0};
  double centre_v_px{0};

  [[nodiscard]] STEREOGRID_HD double disparity(double u, double v) const {
    return at_centre + per_u * (u - centre_u_px) + per_v * (v - centre_v_px);
  }
};

/// Road plane in disparity space: with g the unit vector to the ground in the camera frame, g·X = height and X = Z·(…,
/// 1), Z = f·b/d give d = (b/height)·(g_x (u−u0) + g_y (v−v0) + g_z f). method: eq. 1b, with roll.
inline RoadPlane road_plane(const Rig& rig, const Ground& ground) {
  const double scale{rig.baseline_m / ground.height_m};
  const double cos_pitch{std::cos(ground.pitch_rad)};
  return {scale * rig.focal_px * std::sin(ground.pitch_rad), scale * cos_pitch * std::sin(ground.roll_rad),
          scale * cos_pitch * std::cos(ground.roll_rad), rig.centre_u_px, rig.centre_v_px};
}

/// The inverse of road_plane: g has length 1.
inline Ground ground_of(const Rig& rig, const RoadPlane& plane) {
  const double gz{plane.at_centre / rig.focal_px};
  const double length{std::sqrt(plane.per_u * plane.per_u + plane.per_v * plane.per_v + gz * gz)};
  return {rig.baseline_m / length, std::asin(gz / length), std::atan2(plane.per_u, plane.per_v), true};
}

/// Row of the horizon in the column u0: v0 − f·tan(pitch). specification §1.
inline double horizon_row(const Rig& rig, const Ground& ground) {
  return rig.centre_v_px - rig.focal_px * std::tan(ground.pitch_rad);
}

/// Row at which a vertical obstacle at disparity d reaches `height_m` above the road. specification §3.1, method eq.
/// 1a.
inline double row_at_height(const Rig& rig, const Ground& ground, double d, double height_m) {
  return horizon_row(rig, ground) + d * (ground.height_m - height_m) / (rig.baseline_m * std::cos(ground.pitch_rad));
}

}  // namespace stereogrid
