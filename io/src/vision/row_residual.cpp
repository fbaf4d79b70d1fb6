// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "stereogrid/error.hpp"
#include "stereogrid/io/rectifier.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

// sizes of patches that are searched in the right image, px
constexpr int half_width_px{7};
constexpr int half_height_px{4};
constexpr int rows_px{6};
constexpr int farthest_px{128};

/// Vertical distance (px) of the best place of a patch of the left image in the right one; none: no place is sure.
std::optional<double> vertical_residual(const cv::Mat& left, const cv::Mat& right, cv::Point at) {
  constexpr double sure{0.9};  // correlation
  const cv::Rect patch{at.x - half_width_px, at.y - half_height_px, 2 * half_width_px + 1, 2 * half_height_px + 1};
  const cv::Rect image{0, 0, left.cols, left.rows};
  const cv::Rect search{cv::Rect{patch.x - farthest_px, patch.y - rows_px, patch.width + farthest_px + half_width_px,
                                 patch.height + 2 * rows_px} &
                        image};
  if ((patch & image) != patch || search.height < patch.height + 2 * rows_px) return std::nullopt;
  cv::Mat score;
  cv::matchTemplate(right(search), left(patch), score, cv::TM_CCOEFF_NORMED);
  double best{0};
  cv::Point place;
  cv::minMaxLoc(score, nullptr, &best, nullptr, &place);
  if (best < sure || place.y == 0 || place.y + 1 == score.rows) return std::nullopt;
  const auto at_row{[&](int row) { return static_cast<double>(score.at<float>(row, place.x)); }};
  const double bend{at_row(place.y - 1) - 2 * best + at_row(place.y + 1)};
  const double fraction{bend < 0 ? (at_row(place.y - 1) - at_row(place.y + 1)) / (2 * bend) : 0};
  return place.y + fraction - rows_px;
}

cv::Mat view_of(const Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
}

void add_residuals(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right, std::vector<double>& residuals) {
  constexpr int corners{300};
  constexpr double quality{0.01};
  constexpr double apart_px{6};
  std::vector<cv::Point2f> places;
  cv::goodFeaturesToTrack(view_of(left), places, corners, quality, apart_px);
  for (const cv::Point2f& place : places) {
    const cv::Point at{static_cast<int>(std::lround(place.x)), static_cast<int>(std::lround(place.y))};
    if (const auto residual{vertical_residual(view_of(left), view_of(right), at)}) residuals.push_back(*residual);
  }
}

}  // namespace

std::optional<double> row_residual_px(const StereoFrame& frame) {
  constexpr std::size_t fewest{30};
  if (frame.left.empty() || frame.right.width() != frame.left.width() || frame.right.height() != frame.left.height()) {
    return std::nullopt;
  }
  std::vector<double> residuals;
  add_residuals(frame.left, frame.right, residuals);
  if (residuals.size() < fewest) return std::nullopt;
  for (double& residual : residuals) residual = std::abs(residual);
  const auto middle{residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2)};
  std::ranges::nth_element(residuals, middle);
  return *middle;
}

RowResidual row_residual(const RawPair& raw, std::span<const StereoFrame> frames) {
  const int width_px{frames.front().left.width()};
  const int height_px{frames.front().left.height()};
  std::vector<double> residuals;
  double focal_px{1};
  try {
    const Rectifier rectifier{raw, width_px, height_px};
    focal_px = rectifier.rig().focal_px;
    for (const StereoFrame& frame : frames) {
      if (frame.left.width() != width_px || frame.left.height() != height_px) continue;
      add_residuals(rectifier.left(frame.left), rectifier.right(frame.right), residuals);
    }
  } catch (const InputError&) {  // this model cannot be rectified
    residuals.clear();
  }
  RowResidual found{0, residuals.size()};
  for (const double residual : residuals) found.rms_rad += residual * residual / static_cast<double>(residuals.size());
  found.rms_rad = std::sqrt(found.rms_rad) / focal_px;
  return found;
}

}  // namespace stereogrid::io
