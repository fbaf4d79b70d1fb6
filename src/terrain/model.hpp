// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "stereogrid/camera.hpp"

namespace stereogrid {

// Numbers in brackets: docs/terrain.md. x: distance ahead, m; h: camera height above the surface, m; t = h/x: tangent
// of the line of sight, positive downwards; z: elevation above the ground plane, m.

/// Standard deviation of a block's disparity where the frame shows no larger one, px.
constexpr float block_sigma_px{0.3f};

/// Width of ground that leads past an edge, in heights of the vehicle. Narrower edges are passed by.
constexpr float passage_width{0.4f};

/// Widest ditch into which a wheel falls by less than a step, in steps. The wheel's radius is two steps.
constexpr double crossed_ditch{2 * std::numbers::sqrt3};

/// Level camera above the ground plane of a frame.
struct TerrainCamera {
  float focal_px;
  float baseline_m;
  float focal_baseline_pxm;
  float height_m;
  float tangent_at_origin;  ///< tangent of the line of sight of pixel (0, 0)
  float tangent_per_u;
  float tangent_per_v;

  TerrainCamera(const Rig& rig, const Ground& ground)
      : focal_px{static_cast<float>(rig.focal_px)},
        baseline_m{static_cast<float>(rig.baseline_m)},
        focal_baseline_pxm{static_cast<float>(rig.focal_px * rig.baseline_m)},
        height_m{static_cast<float>(ground.height_m)} {
    const RoadPlane plane{road_plane(rig, ground)};
    const double per_px{ground.height_m / (rig.focal_px * rig.baseline_m)};
    tangent_at_origin = static_cast<float>(per_px * plane.disparity(0, 0));
    tangent_per_u = static_cast<float>(per_px * plane.per_u);
    tangent_per_v = static_cast<float>(per_px * plane.per_v);
  }

  /// t = H·d_g/(f·b), with the plane's disparity d_g.
  [[nodiscard]] STEREOGRID_HD float tangent(float u, float v) const {
    return tangent_at_origin + tangent_per_u * u + tangent_per_v * v;
  }
  [[nodiscard]] STEREOGRID_HD float range(float disparity) const { return focal_baseline_pxm / disparity; }
  /// σ_x = x²·σ_d/(f·b) (1).
  [[nodiscard]] STEREOGRID_HD float range_sigma(float x, float sigma_px) const {
    return x * x * sigma_px / focal_baseline_pxm;
  }
  /// σ_z = h·x·σ_d/(f·b) (1): the error runs along the ray.
  [[nodiscard]] STEREOGRID_HD float elevation_sigma(float h, float x, float sigma_px) const {
    return h * x * sigma_px / focal_baseline_pxm;
  }
  /// Noise of the height over a surface of slope s: |h + s·x|·x·σ_d/(f·b) (1).
  [[nodiscard]] STEREOGRID_HD float height_sigma(float h, float slope, float x, float sigma_px) const {
    return elevation_sigma(std::abs(h + slope * x), x, sigma_px);
  }
  /// Distance between two rows on a level surface, x²/(f·h) (3).
  [[nodiscard]] STEREOGRID_HD float row_length(float h, float x) const { return x * x * tangent_per_v / h; }
  /// Slope of a surface at x whose disparity grows by `per_row` from row to row: b_v = B/(h + s·x) (2).
  [[nodiscard]] STEREOGRID_HD float slope_of(float per_row, float h, float x) const {
    return (focal_baseline_pxm * tangent_per_v / per_row - h) / x;
  }
  /// A surface is steeper than any ground: its disparity grows by less than half of B/(h + S·x) per row (2).
  /// `steepest`: h + S·x, m.
  [[nodiscard]] STEREOGRID_HD bool is_upright(float per_row, float steepest) const {
    return per_row * steepest < 0.5f * focal_baseline_pxm * tangent_per_v;
  }
  /// Growth of the disparity per row on a level surface, B/h (2).
  [[nodiscard]] STEREOGRID_HD float level_growth(float h) const { return focal_baseline_pxm * tangent_per_v / h; }
};

/// Line of the ground before the first visible one.
struct FirstGround {
  float z{0};  ///< below the camera
  float slope{0};

  [[nodiscard]] STEREOGRID_HD float elevation(float at_x) const { return z + slope * at_x; }
};

/// `surface`: plane of the nearest visible ground.
inline FirstGround first_ground(const Ground& ground, const Ground& surface) {
  const double turn_rad{surface.pitch_rad - ground.pitch_rad};
  return {static_cast<float>(ground.height_m - surface.height_m / std::cos(turn_rad)),
          static_cast<float>(std::tan(turn_rad))};
}

struct TerrainLimits {
  float step_m;       ///< largest step that a wheel climbs
  float slope;        ///< tangent of the steepest slope
  float height_m;     ///< clearance
  float rays_from_m;  ///< least height of what rays show
  float drop_slope;   ///< tangent of the line of sight up to which a gap with lower ground behind it is a drop
};

}  // namespace stereogrid
