// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "stereogrid/frame.hpp"
#include "stereogrid/io/opencv_matcher.hpp"

namespace stereogrid::research {

/// Matches with OpenCV before the pipeline does.
class OpencvStage {
 public:
  /// `name`: "own" (nothing to do), "opencv-bm" or "opencv-sgbm".
  OpencvStage(const std::string& name, int disparities);

  /// Replaces the frame's right image by OpenCV's disparities.
  void match(StereoFrame& frame) const;

 private:
  std::optional<io::OpencvMatcher> matcher_;
  int disparities_;
};

}  // namespace stereogrid::research
