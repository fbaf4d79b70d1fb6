// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "stereogrid/camera.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid {

/// Row v of a camera's image in the image of a camera rotated downwards about the baseline, whose centre may lie in
/// another row, `turned_centre_v`. Rows map to rows; their scale changes. docs/method.md §2.1.
struct TurnedRow {
  TurnedRow(const Rig& rig, double turned_centre_v, double sin_angle, double cos_angle, double row)
      : centre_u{rig.cx_px} {
    const double y{(row - rig.cy_px) / rig.focal_px};
    depth = y * sin_angle + cos_angle;
    v = turned_centre_v + rig.focal_px * (y * cos_angle - sin_angle) / depth;
  }

  [[nodiscard]] double u_of(double u) const { return centre_u + (u - centre_u) / depth; }

  double centre_u;
  double depth;  ///< along the turned axis of a point at depth 1 along the other one; 0 or less: behind the camera
  double v;
};

class Cpu;

/// Turns a pitched camera level: K·R·K⁻¹ with a rotation about the baseline, the same for both images, so that rows
/// stay aligned. Parts that the camera does not see become 0.
class Levelling {
 public:
  explicit Levelling(const Rig& rig);

  /// True if the rig needs levelling.
  [[nodiscard]] bool is_needed() const { return !mapping_.is_identity(); }
  /// The rig whose images come out: see LevelMapping::level_rig.
  [[nodiscard]] const Rig& level_rig() const { return mapping_.level_rig(); }
  void apply(Cpu& cpu, View<const std::uint8_t> pitched, View<std::uint8_t> level) const;
  /// The same for a disparity image (px, 0 = none). Depth is measured along another axis then, so d changes too. The
  /// nearest pixel is taken: between a near and a far one there is nothing.
  void apply(Cpu& cpu, View<const float> pitched, View<float> level) const;

 private:
  /// level(u, v) = pixel_at(u, v, depth): place in the pitched image, and the depth along its axis of a point at depth
  /// 1 along the level one.
  template <class Pixel>
  void for_pixels(Cpu& cpu, View<Pixel> level, const auto& pixel_at) const;

  LevelMapping mapping_;
  double centre_v_px_;  ///< centre of the pitched images
  double sin_pitch_;
  double cos_pitch_;
};

}  // namespace stereogrid
