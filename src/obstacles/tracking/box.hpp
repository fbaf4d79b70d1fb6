// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "obstacles/segmentation/clusters.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// A side of the box around an outline, square to an axis.
struct BoxSide {
  double at_m{0};       ///< along the axis
  double sigma_m{0};    ///< infinite: it is hidden, or cut off, or only assumed
  bool is_near{false};  ///< visible to the camera, or both ends of a facing side: later observations are of the same
                        ///< side

  [[nodiscard]] bool is_seen() const;
};

/// Sides of the box around a cluster's outline, with standard deviations. docs/method.md §11.2.
struct BoxView {
  /// `camera`: position and viewing direction, world axes.
  BoxView(const Cluster& cluster, double yaw_rad, const Pose2& camera, const Rig& rig);

  std::array<Point2, 2> axes;                     ///< along yaw_rad, and across it
  std::array<std::array<BoxSide, 2>, 2> sides{};  ///< by axis, the side with the smaller coordinate first

  /// Standard deviation of the visible side along yaw_rad; infinite: none visible.
  [[nodiscard]] double face_sigma_m() const;
};

/// Box of a thing from all frames: its sides around a reference point that is fixed on the thing.
struct TrackedBox {
  double yaw_rad{0};
  std::array<std::array<double, 2>, 2> reach_m{};  ///< by axis: coordinates of its sides, from the reference point
  std::array<std::array<double, 2>, 2> sigma_m{};  ///< by side; infinite: never seen

  /// As it is seen now.
  void begin(const BoxView& view, double yaw, Point2 place);
  /// After the place has been corrected.
  void update(const BoxView& view, Point2 place);
  /// Centre of the box, from the reference point.
  [[nodiscard]] Point2 middle() const;
  [[nodiscard]] double extent_m(std::size_t axis) const { return reach_m[axis][1] - reach_m[axis][0]; }
  /// Infinite: an end has never been seen.
  [[nodiscard]] double extent_sigma_m(std::size_t axis) const;
};

}  // namespace stereogrid
