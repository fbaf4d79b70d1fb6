// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/camera.hpp"

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

}  // namespace stereogrid
