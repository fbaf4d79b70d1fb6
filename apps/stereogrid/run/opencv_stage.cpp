// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "run/opencv_stage.hpp"

#include <chrono>

namespace stereogrid::app {

OpencvStage::OpencvStage(const std::string& name, int disparities) : disparities_{disparities} {
  if (name == "opencv-bm") matcher_ = io::OpencvMatcher::block;
  if (name == "opencv-sgbm") matcher_ = io::OpencvMatcher::semi_global;
}

double OpencvStage::match(StereoFrame& frame) const {
  if (!matcher_) return 0;
  const auto start{std::chrono::steady_clock::now()};
  frame.disparity = io::match_with_opencv(*matcher_, frame.left, frame.right, disparities_);
  frame.right = {};
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace stereogrid::app
