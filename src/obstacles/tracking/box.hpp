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
  bool is_near{false};  ///< the camera sees it, or both ends of what faces it: what is seen of it later is the same

  [[nodiscard]] bool is_seen() const;
};

/// Where the sides of the box around a cluster's outline are, and how surely. docs/method.md §11.2.
struct BoxView {
  /// `camera`: where it is and looks, world axes.
  BoxView(const Cluster& cluster, double yaw_rad, const Pose2& camera, const Rig& rig);

  std::array<Point2, 2> axes;                     ///< along yaw_rad, and across it
  std::array<std::array<BoxSide, 2>, 2> sides{};  ///< of each axis, that of the smaller coordinate first

  /// Of the side along yaw_rad that the camera sees; infinite: of none.
  [[nodiscard]] double face_sigma_m() const;
};

/// What is known of a thing's box from all frames: its sides around a place that stays where it is on the thing,
/// whatever comes into view.
struct TrackedBox {
  double yaw_rad{0};
  std::array<std::array<double, 2>, 2> reach_m{};  ///< of each axis: coordinates of its sides, from the place
  std::array<std::array<double, 2>, 2> sigma_m{};  ///< of each side; infinite: it has not been seen

  /// As it is seen now.
  void begin(const BoxView& view, double yaw, Point2 place);
  /// After the place has been corrected.
  void update(const BoxView& view, Point2 place);
  /// Of the box, from the place.
  [[nodiscard]] Point2 middle() const;
  [[nodiscard]] double extent_m(std::size_t axis) const { return reach_m[axis][1] - reach_m[axis][0]; }
  /// Infinite: an end has never been seen.
  [[nodiscard]] double extent_sigma_m(std::size_t axis) const;
};

}  // namespace stereogrid
