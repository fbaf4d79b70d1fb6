// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "stereogrid/evaluation/labels.hpp"

namespace stereogrid::evaluation {

/// The road as y = right · x + ahead · z + down in the camera's frame.
struct RoadPlane {
  double right{0};
  double ahead{0};
  double down_m{0};

  [[nodiscard]] double height_of(const CameraPoint& p) const { return p.x_m * right + p.z_m * ahead + down_m - p.y_m; }
};

/// Least squares through low points: 4–30 m ahead, within 8 m of the axis; within 0.35 m of `start`, then
/// twice within 0.12 m of the plane before. Stays where it is with too few points.
[[nodiscard]] RoadPlane fit_road(std::span<const CameraPoint> points, const RoadPlane& start);

}  // namespace stereogrid::evaluation
