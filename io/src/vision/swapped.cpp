// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "stereogrid/io/recording.hpp"

namespace stereogrid::io {
namespace {

constexpr int coarse_width_px{400};
constexpr int disparities{48};

cv::Mat coarse(const Image<std::uint8_t>& image, int largest_width_px = coarse_width_px) {
  const cv::Mat whole{image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.data())};
  const double scale{std::min(1.0, static_cast<double>(largest_width_px) / image.width())};
  cv::Mat small;
  cv::resize(whole, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

/// Share of the pixels that have a sure match at a disparity of at least one coarse pixel.
double matched_share(const cv::Mat& left, const cv::Mat& right) {
  const auto matcher{
      cv::StereoSGBM::create(0, disparities, 5, 8 * 25, 32 * 25, 1, 31, 15, 100, 1, cv::StereoSGBM::MODE_SGBM_3WAY)};
  cv::Mat disparity;  // in sixteenths of a pixel
  matcher->compute(left, right, disparity);
  return cv::countNonZero(disparity >= 16) / static_cast<double>(disparity.total());
}

/// Disparities (px) of a rectified pair, negative ones too, at half resolution of large images; sorted.
struct SignedDisparities {
  std::vector<float> all_px;
  double upper_mean_px{0};
  double lower_mean_px{0};
  std::size_t pixels{0};
};

SignedDisparities signed_disparities(const StereoFrame& frame) {
  constexpr int largest_width_px{640};
  constexpr int lowest{-64};
  constexpr int count_small{160};
  constexpr int count_large{384};  // near scenes: without their own disparities they match at wrong ones
  constexpr float unit{16};        // unit of OpenCV's disparities
  SignedDisparities found;
  const double scale{std::min(1.0, double{largest_width_px} / frame.left.width())};
  const cv::Mat left{coarse(frame.left, largest_width_px)};
  const int count{left.cols > count_large ? count_large : count_small};
  if (left.cols <= count || frame.left.height() != frame.right.height()) return found;
  cv::Mat disparity;
  cv::StereoSGBM::create(lowest, count, 5, 8 * 25, 32 * 25, 1, 31, 15, 100, 1, cv::StereoSGBM::MODE_SGBM_3WAY)
      ->compute(left, coarse(frame.right, largest_width_px), disparity);
  found.pixels = disparity.total();
  std::array<double, 2> sum{};
  std::array<double, 2> counted{};
  for (int v{0}; v < disparity.rows; ++v) {
    const std::size_t half{2 * v < disparity.rows ? 0U : 1U};
    for (int u{0}; u < disparity.cols; ++u) {
      const float d{static_cast<float>(disparity.at<std::int16_t>(v, u)) / unit};
      if (d < static_cast<float>(lowest)) continue;
      found.all_px.push_back(d / static_cast<float>(scale));
      sum.at(half) += found.all_px.back();
      ++counted.at(half);
    }
  }
  std::ranges::sort(found.all_px);
  found.upper_mean_px = sum[0] / std::max(1.0, counted[0]);
  found.lower_mean_px = sum[1] / std::max(1.0, counted[1]);
  return found;
}

}  // namespace

std::optional<double> negative_disparity_px(const StereoFrame& frame) {
  constexpr double fewest{0.15};  // share of the pixels that match
  constexpr std::size_t checked_percent{5};
  constexpr std::size_t farthest_percent{2};
  constexpr float noticeable_px{-1};
  if (frame.right.empty() || frame.right.width() != frame.left.width()) return std::nullopt;
  const SignedDisparities found{signed_disparities(frame)};
  const auto percentile{[&](std::size_t percent) { return found.all_px[found.all_px.size() * percent / 100]; }};
  if (found.all_px.empty() || static_cast<double>(found.all_px.size()) < fewest * static_cast<double>(found.pixels)) {
    return std::nullopt;
  }
  const bool are_swapped{found.lower_mean_px < found.upper_mean_px - noticeable_px};  // near objects have smaller ones
  if (are_swapped || percentile(checked_percent) > noticeable_px) return std::nullopt;
  return percentile(farthest_percent);
}

std::optional<double> near_disparity_px(const StereoFrame& frame, double beyond_px) {
  constexpr double fewest{0.2};  // share of the pixels that match there
  constexpr std::size_t nearest_percent{95};
  if (frame.right.empty() || frame.right.width() != frame.left.width()) return std::nullopt;
  const SignedDisparities found{signed_disparities(frame)};
  const auto beyond{std::ranges::count_if(found.all_px, [&](float d) { return d >= beyond_px; })};
  if (found.all_px.empty() || static_cast<double>(beyond) < fewest * static_cast<double>(found.pixels))
    return std::nullopt;
  return found.all_px[found.all_px.size() * nearest_percent / 100];
}

std::optional<std::string> finding_if_shifted(const StereoFrame& frame, const Rig& rig) {
  const auto far_px{negative_disparity_px(frame)};
  if (!far_px) return std::nullopt;
  return fmt::format(
      "frame {}: the farthest points have disparities of {:.1f} px, which no calibration explains: the right image is "
      "shifted by that offset, and distances are too large. Rectify the pair again, or add 'cx_right_px: {:.1f}' "
      "to calibration.yaml (one with 'from: FILE' where another tool has written the calibration).",
      frame.name, *far_px, rig.cx_px - *far_px);
}

double coarse_match_share(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right) {
  if (left.width() < 2 * disparities || left.height() < 16) return 0;
  if (left.width() != right.width() || left.height() != right.height()) return 0;
  return matched_share(coarse(left), coarse(right));
}

std::optional<std::string> finding_if_swapped(const StereoFrame& frame) {
  const double as_named{coarse_match_share(frame.left, frame.right)};
  if (as_named > 0.5) return std::nullopt;
  const double swapped{coarse_match_share(frame.right, frame.left)};
  if (swapped < 0.1 || swapped < 2 * as_named || negative_disparity_px(frame)) return std::nullopt;
  return fmt::format(
      "frame {}: left and right seem to be swapped: {:.0f} % of the image matches at negative disparities, {:.0f} % at "
      "positive ones. Exchange the two folders or images. If writing in them is mirrored, mirror them back instead.",
      frame.name, 100 * swapped, 100 * as_named);
}

}  // namespace stereogrid::io
