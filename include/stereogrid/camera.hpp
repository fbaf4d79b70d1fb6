// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid {

/// A rectified stereo pair and how it is mounted. The left image is the reference; both cameras are alike; rows are
/// aligned; pixel centres are at integers.
///
/// Frames: image (u right, v down); camera (x right, y down, z forward); vehicle (x forward, y left, z up, origin on
/// the ground below the left camera).
struct Rig {
  int width_px{0};
  int height_px{0};
  double focal_px{0};
  double centre_u_px{0};
  double centre_v_px{0};
  double baseline_m{0};
  double camera_height_m{1.65};  ///< left camera's centre above the ground
  double camera_pitch_rad{0};    ///< positive: looks down
  double camera_roll_rad{0};     ///< positive: right side down

  friend bool operator==(const Rig&, const Rig&) = default;
};

/// Everything that makes a rig unusable, a sentence each; empty: nothing. Numbers that are none, too small or too large
/// for any camera: a baseline in millimetres, a height in centimetres, angles in degrees, a principal point outside the
/// image. A width or height of 0 is not looked at: a calibration may not know the images' size.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> problems(const Rig& rig);

/// What can be worked with but hardly any vehicle has, a sentence each: worth a warning, since a slip in a unit or a
/// digit looks like this. Of a rig without problems.
[[nodiscard]] STEREOGRID_EXPORT std::vector<std::string> oddities(const Rig& rig);

/// The road as the left camera sees it in one frame.
struct Ground {
  double height_m{1.65};  ///< camera centre above the road
  double pitch_rad{0};    ///< positive: camera looks down on the road
  double roll_rad{0};     ///< positive: camera's right side is down relative to the road
  bool estimated{false};  ///< measured in this frame; false: carried over or taken from the calibration

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
