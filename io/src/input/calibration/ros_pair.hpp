// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "input/origin.hpp"
#include "stereogrid/io/ros_camera.hpp"

namespace stereogrid::io {

/// Terms in messages about a camera.
struct RosTerms {
  const char* k;
  const char* d;
  const char* r;
  const char* p;
  const char* if_rectified;  ///< remedies for rectified images, and for a measured baseline: a
  const char* if_measured;   ///< sentence that begins with a blank; "": nothing
};

inline constexpr const char* calibrate_together{
    "Calibrate both cameras together (camera_calibration's cameracalibrator with two cameras), and use its left and "
    "right file."};

struct RosSide {
  const RosCamera& camera;
  const Origin& origin;
};

/// Rig of rectified images, or a raw pair whose rig has its size only. `baseline_is_given`: replaces the baseline here,
/// which may then be zero. Throws InputError.
[[nodiscard]] Calibration ros_pair(const RosSide& left, const RosSide& right, const RosTerms& terms, bool are_rectified,
                                   bool baseline_is_given);

}  // namespace stereogrid::io
