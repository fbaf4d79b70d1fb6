// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "stereogrid/frame.hpp"
#include "stereogrid/io/opencv_matcher.hpp"

namespace stereogrid::app {

/// Stands before the pipeline where OpenCV is to match.
class OpencvStage {
 public:
  /// `name`: "own" (nothing to do), "opencv-bm" or "opencv-sgbm".
  OpencvStage(const std::string& name, int disparities);

  /// Puts OpenCV's disparities in the place of the frame's right image. Returns the milliseconds it took.
  double match(StereoFrame& frame) const;

 private:
  std::optional<io::OpencvMatcher> matcher_;
  int disparities_;
};

}  // namespace stereogrid::app
