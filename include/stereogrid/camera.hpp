// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// Rectified stereo pair with extrinsics. The left image is the reference; both cameras have equal intrinsics; rows are
/// aligned; pixel centres are at integers.
///
/// Frames: image (u right, v down); camera (x right, y down, z forward); vehicle (x forward, y left, z up, origin on
/// the ground: below the left camera, unless camera_x_m or camera_y_m is set).
struct Rig {
  int width_px{0};
  int height_px{0};
  double focal_px{0};
  double cx_px{0};
  double cy_px{0};
  double baseline_m{0};
  double camera_height_m{1.65};  ///< height of the left camera's centre above the ground
  double camera_pitch_rad{0};    ///< positive: downwards
  double camera_roll_rad{0};     ///< positive: right side down
  double camera_x_m{0};          ///< position of the left camera in the vehicle frame, ahead
  double camera_y_m{0};          ///< to the left
  double camera_yaw_rad{0};      ///< heading of the optical axis in the vehicle frame; 0: ahead, positive: to the left

  friend bool operator==(const Rig&, const Rig&) = default;
};

/// Problems that make a rig unusable, one message each; empty: none. Checks for non-finite and implausible values: a
/// baseline in millimetres, a height in centimetres, angles in degrees, a principal point outside the image. A width or
/// height of 0 is not checked, as a calibration may lack the image size.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> problems(const Rig& rig);

/// Unusual values of a rig without problems, one message each. They are worth a warning, as they may be errors of a
/// unit or a digit.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> oddities(const Rig& rig);

/// Ground plane of one frame, relative to the left camera.
struct Ground {
  double height_m{1.65};  ///< camera centre above the road
  double pitch_rad{0};    ///< positive: the camera is pitched downwards
  double roll_rad{0};     ///< positive: camera's right side is down relative to the road
  bool estimated{false};  ///< measured in this frame; false: carried over, of the calibration, or a slope in view

  // Standard deviations and correlations of the errors; all 0: trusted.
  double height_sigma_m{0};
  double pitch_sigma_rad{0};
  double roll_sigma_rad{0};
  double height_pitch_correlation{0};
  double height_roll_correlation{0};
  double pitch_roll_correlation{0};

  friend bool operator==(const Ground&, const Ground&) = default;
};

}  // namespace stereogrid
