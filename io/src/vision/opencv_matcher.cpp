// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/opencv_matcher.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>

namespace stereogrid::io {
namespace {

constexpr int window_px{21};
constexpr int block_px{5};
constexpr int uniqueness_percent{10};
constexpr int speckle_px{100};
constexpr int speckle_range_px{2};
constexpr int left_right_px{1};

cv::Ptr<cv::StereoMatcher> matcher_of(OpencvMatcher matcher, int disparities) {
  if (matcher == OpencvMatcher::semi_global) {
    constexpr int area{block_px * block_px};
    return cv::StereoSGBM::create(0, disparities, block_px, 8 * area, 32 * area, left_right_px, 0, uniqueness_percent,
                                  speckle_px, speckle_range_px, cv::StereoSGBM::MODE_SGBM_3WAY);
  }
  const auto block{cv::StereoBM::create(disparities, window_px)};
  block->setUniquenessRatio(uniqueness_percent);
  block->setSpeckleWindowSize(speckle_px);
  block->setSpeckleRange(speckle_range_px);
  block->setDisp12MaxDiff(left_right_px);
  return block;
}

}  // namespace

Image<float> match_with_opencv(OpencvMatcher matcher, const Image<std::uint8_t>& left, const Image<std::uint8_t>& right,
                               int disparities) {
  Image<float> disparity{left.width(), left.height()};
  const int rounded{(disparities + 15) / 16 * 16};
  if (left.width() <= rounded + window_px || left.height() <= window_px) return disparity;
  const auto mat_of{[](const Image<std::uint8_t>& image) {
    return cv::Mat{image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
  }};
  cv::Mat sixteenths;  // OpenCV's fixed point; negative: none
  matcher_of(matcher, rounded)->compute(mat_of(left), mat_of(right), sixteenths);
  for (int v{0}; v < disparity.height(); ++v) {
    const auto* row{sixteenths.ptr<std::int16_t>(v)};
    std::transform(row, row + disparity.width(), disparity.row(v),
                   [](std::int16_t d) { return d > 0 ? static_cast<float>(d) / 16 : 0.0F; });
  }
  return disparity;
}

}  // namespace stereogrid::io
