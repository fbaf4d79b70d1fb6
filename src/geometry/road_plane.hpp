// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "geometry/matrix3.hpp"
#include "host_device.hpp"
#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Disparity of the road at a pixel: at_centre + per_u·(u − u0) + per_v·(v − v0), in px.
struct RoadPlane {
  double at_centre{0};
  double per_u{0};
  double per_v{0};
  double cx_px{0};
  double cy_px{0};

  [[nodiscard]] STEREOGRID_HD double disparity(double u, double v) const {
    return at_centre + per_u * (u - cx_px) + per_v * (v - cy_px);
  }

  friend bool operator==(const RoadPlane&, const RoadPlane&) = default;
};

/// Road plane in disparity space: with g the unit vector to the ground in the camera frame, g·X = height and X = Z·(…,
/// 1), Z = f·b/d give d = (b/height)·(g_x (u−u0) + g_y (v−v0) + g_z f). docs/method.md §1.2.
STEREOGRID_HD inline RoadPlane road_plane(const Rig& rig, const Ground& ground) {
  const double scale{rig.baseline_m / ground.height_m};
  const double cos_pitch{std::cos(ground.pitch_rad)};
  return {scale * rig.focal_px * std::sin(ground.pitch_rad), scale * cos_pitch * std::sin(ground.roll_rad),
          scale * cos_pitch * std::cos(ground.roll_rad), rig.cx_px, rig.cy_px};
}

/// The inverse of road_plane: g has length 1.
STEREOGRID_HD inline Ground ground_of(const Rig& rig, const RoadPlane& plane) {
  const double gz{plane.at_centre / rig.focal_px};
  const double length{std::sqrt(plane.per_u * plane.per_u + plane.per_v * plane.per_v + gz * gz)};
  return {rig.baseline_m / length, std::asin(gz / length), std::atan2(plane.per_u, plane.per_v), true};
}

/// `ground` relative to a camera at the same place that is pitched down by `angle_rad` more.
inline Ground seen_from(const Ground& ground, double angle_rad) {
  // the unit vector to the ground in the camera frame, turned about its x axis
  const double x{std::cos(ground.pitch_rad) * std::sin(ground.roll_rad)};
  const double y{std::cos(ground.pitch_rad) * std::cos(ground.roll_rad)};
  const double z{std::sin(ground.pitch_rad)};
  const double turned_y{y * std::cos(angle_rad) - z * std::sin(angle_rad)};
  const double turned_z{y * std::sin(angle_rad) + z * std::cos(angle_rad)};
  Ground seen{ground};
  seen.pitch_rad = std::asin(turned_z);
  seen.roll_rad = std::atan2(x, turned_y);
  return seen;
}

/// Derivatives of the road plane (at_centre, per_u, per_v) with respect to (height, pitch, roll).
STEREOGRID_HD inline Matrix3 plane_by_ground(const Rig& rig, const Ground& ground) {
  const RoadPlane plane{road_plane(rig, ground)};
  const double scale{rig.baseline_m / ground.height_m};
  const double sin_pitch{std::sin(ground.pitch_rad)};
  return {{{-plane.at_centre / ground.height_m, scale * rig.focal_px * std::cos(ground.pitch_rad), 0},
           {-plane.per_u / ground.height_m, -scale * sin_pitch * std::sin(ground.roll_rad), plane.per_v},
           {-plane.per_v / ground.height_m, -scale * sin_pitch * std::cos(ground.roll_rad), -plane.per_u}}};
}

/// Covariance of (height, pitch, roll).
STEREOGRID_HD inline Matrix3 covariance_of(const Ground& ground) {
  const double height{ground.height_sigma_m};
  const double pitch{ground.pitch_sigma_rad};
  const double roll{ground.roll_sigma_rad};
  const double height_pitch{ground.height_pitch_correlation * height * pitch};
  const double height_roll{ground.height_roll_correlation * height * roll};
  const double pitch_roll{ground.pitch_roll_correlation * pitch * roll};
  return {{{height * height, height_pitch, height_roll},
           {height_pitch, pitch * pitch, pitch_roll},
           {height_roll, pitch_roll, roll * roll}}};
}

/// `ground` with that covariance of (height, pitch, roll); its diagonal must be positive.
STEREOGRID_HD inline Ground with_covariance(Ground ground, const Matrix3& covariance) {
  ground.height_sigma_m = std::sqrt(covariance[0][0]);
  ground.pitch_sigma_rad = std::sqrt(covariance[1][1]);
  ground.roll_sigma_rad = std::sqrt(covariance[2][2]);
  ground.height_pitch_correlation = covariance[0][1] / (ground.height_sigma_m * ground.pitch_sigma_rad);
  ground.height_roll_correlation = covariance[0][2] / (ground.height_sigma_m * ground.roll_sigma_rad);
  ground.pitch_roll_correlation = covariance[1][2] / (ground.pitch_sigma_rad * ground.roll_sigma_rad);
  return ground;
}

/// Standard deviation, in px, of the disparity that road_plane gives at a pixel.
STEREOGRID_HD inline double plane_sigma_px(const Rig& rig, const Ground& ground, double u, double v) {
  const Vector3 by_ground{transposed(plane_by_ground(rig, ground)) * Vector3{1, u - rig.cx_px, v - rig.cy_px}};
  const Vector3 carried{covariance_of(ground) * by_ground};
  const double variance{by_ground[0] * carried[0] + by_ground[1] * carried[1] + by_ground[2] * carried[2]};
  return variance > 0 ? std::sqrt(variance) : 0.0;
}

/// Row of the horizon in the column u0: v0 − f·tan(pitch). docs/method.md §1.3.
STEREOGRID_HD inline double horizon_row(const Rig& rig, const Ground& ground) {
  return rig.cy_px - rig.focal_px * std::tan(ground.pitch_rad);
}

/// Row at which a vertical obstacle at disparity d reaches `height_m` above the road. docs/method.md §1.3.
struct RowsByHeight {
  double horizon;
  double baseline_across_m;  ///< b·cos(pitch)
  double camera_height_m;

  STEREOGRID_HD RowsByHeight(const Rig& rig, const Ground& ground)
      : horizon{horizon_row(rig, ground)},
        baseline_across_m{rig.baseline_m * std::cos(ground.pitch_rad)},
        camera_height_m{ground.height_m} {}

  STEREOGRID_HD RowsByHeight(double horizon_row_px, double baseline_across, double height_m)
      : horizon{horizon_row_px}, baseline_across_m{baseline_across}, camera_height_m{height_m} {}

  [[nodiscard]] STEREOGRID_HD double row(double d, double height_m) const {
    return horizon + d * (camera_height_m - height_m) / baseline_across_m;
  }
};
STEREOGRID_HD inline double row_at_height(const Rig& rig, const Ground& ground, double d, double height_m) {
  return RowsByHeight{rig, ground}.row(d, height_m);
}

}  // namespace stereogrid
