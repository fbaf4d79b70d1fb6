// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "compare/opencv_stage.hpp"

namespace stereogrid::research {

OpencvStage::OpencvStage(const std::string& name, int disparities) : disparities_{disparities} {
  if (name == "opencv-bm") matcher_ = io::OpencvMatcher::block;
  if (name == "opencv-sgbm") matcher_ = io::OpencvMatcher::semi_global;
}

void OpencvStage::match(StereoFrame& frame) const {
  if (!matcher_) return;
  frame.disparity = io::match_with_opencv(*matcher_, frame.left, frame.right, disparities_);
  frame.right = {};
}

}  // namespace stereogrid::research
