// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>

#include "landmarks.hpp"

namespace stereogrid {

/// A motion that enough landmarks agree on.
struct MotionFit {
  cv::Affine3d now_from_reference;
  std::vector<int> inliers;  ///< places in the tracks
};

/// Motion of the camera. `expected`: by constant motion; none: unknown. If the majority's motion is not `plausible`,
/// the points near the expected motion decide. None: too few agree.
[[nodiscard]] std::optional<MotionFit> fit_motion(const Landmarks& landmarks, const Tracks& tracks,
                                                  const std::optional<cv::Affine3d>& expected, const Rig& rig,
                                                  const std::function<bool(const cv::Affine3d&)>& plausible);

}  // namespace stereogrid
