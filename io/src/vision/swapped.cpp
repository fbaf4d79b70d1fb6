// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {
namespace {

constexpr int coarse_width_px{400};
constexpr int disparities{48};

cv::Mat coarse(const Image<std::uint8_t>& image) {
  const cv::Mat whole{image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
  const double scale{std::min(1.0, double{coarse_width_px} / image.width())};
  cv::Mat small;
  cv::resize(whole, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

/// Share of the pixels that have a sure match at a disparity of at least one coarse pixel.
double matched_share(const cv::Mat& left, const cv::Mat& right) {
  const auto matcher{cv::StereoSGBM::create(0, disparities, 5, 8 * 25, 32 * 25, 1, 31, 15, 100, 1)};
  cv::Mat disparity;  // in sixteenths of a pixel
  matcher->compute(left, right, disparity);
  return cv::countNonZero(disparity >= 16) / static_cast<double>(disparity.total());
}

}  // namespace

double coarse_match_share(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right) {
  if (left.width() < 2 * disparities || left.height() < 16) return 0;
  if (left.width() != right.width() || left.height() != right.height()) return 0;
  return matched_share(coarse(left), coarse(right));
}

std::optional<std::string> complaint_if_swapped(const StereoFrame& frame) {
  const double as_named{coarse_match_share(frame.left, frame.right)};
  const double swapped{coarse_match_share(frame.right, frame.left)};
  if (swapped < 0.1 || swapped < 2 * as_named) return std::nullopt;
  return fmt::format(
      "frame {}: left and right seem to be swapped: {:.0f} % of the image matches at negative disparities, {:.0f} % at "
      "positive ones. Exchange the two folders or images.",
      frame.name, 100 * swapped, 100 * as_named);
}

}  // namespace stereogrid::io
