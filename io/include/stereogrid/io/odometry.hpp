// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <string>

#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::io {

/// What the odometry says of one frame.
struct OdometryStep {
  /// before_from_now, 3 × 4 row-major, of the camera (x right, y down, z forward), metres: takes points of this frame's
  /// camera to that of the frame before. The identity at the first frame.
  std::array<double, 12> camera_motion{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Pose2 world_from_vehicle;  ///< world: the vehicle frame of the first frame
  bool measured{false};      ///< false: the first frame, or the last motion carried on
  bool standing{false};      ///< nothing in the picture moves: the motion is exactly none
  int tracked{0};            ///< points followed from the reference frame to this one, with depth
  int inliers{0};            ///< of these, points that agree on the motion
  double spread{0};          ///< share of the parts of the picture (6 × 3) that have inliers
  std::string warning;       ///< empty: none
};

/// Visual odometry from a rectified stereo pair: corners spread over the picture (Shi and Tomasi), followed from frame
/// to frame and from left to right by pyramidal Lucas-Kanade, motion from 3D to 2D by RANSAC and least squares
/// (OpenCV).
///
/// The reference stays the same frame until the camera has moved on, so a standing camera does not drift. What would
/// need an implausible acceleration (something large moves through the picture) is taken for another's motion; then the
/// points that agree with a constant motion decide, and where they are too few the last motion is carried on, with a
/// warning. Steps are put together on the ground, seen with the rig's pitch and roll. The same result for any number of
/// threads.
class VisualOdometry {
 public:
  explicit VisualOdometry(const Rig& rig);
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;
  ~VisualOdometry();

  /// Takes the next frame, with a right image or with disparities; stamps must grow, frames may be missing. Throws
  /// InputError where the frame does not fit the rig; the state is then unchanged.
  OdometryStep update(const StereoFrame& frame);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid::io
