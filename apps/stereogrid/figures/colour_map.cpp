// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/colour_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/imgproc.hpp>

namespace stereogrid::app::figures {
namespace {

/// Straight lines between a few colours at equal distances.
template <std::size_t n>
Colour between(const Colour (&stops)[n], double share) {
  const double place{std::clamp(share, 0.0, 1.0) * (n - 1)};
  const auto i{std::min(static_cast<std::size_t>(place), n - 2)};
  const double t{place - static_cast<double>(i)};
  const auto mix = [t](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround((1 - t) * a + t * b));
  };
  return {mix(stops[i].red, stops[i + 1].red), mix(stops[i].green, stops[i + 1].green),
          mix(stops[i].blue, stops[i + 1].blue)};
}

}  // namespace

Colour occupancy_colour(double share) {
  const std::uint8_t grey{grey_of(static_cast<float>(share))};
  return {grey, grey, grey};
}

Colour sequential_colour(double share) {
  constexpr Colour stops[]{{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  return between(stops, share);
}

Colour count_colour(double share) {
  constexpr Colour stops[]{{252, 252, 250}, {250, 200, 130}, {225, 90, 60}, {130, 25, 90}, {25, 10, 50}};
  return between(stops, share);
}

ColourBar occupancy_bar() {
  return {{"occupancy", 0, 1, {{0, "0"}, {0.5, "0.5"}, {1, "1"}}}, occupancy_colour};
}

ColourBar probability_bar(const std::string& label) {
  return {axis(label, 0, 1, 6), sequential_colour};
}

double count_share(double count, double most) {
  return count > 0 ? std::log1p(count) / std::log1p(std::max(most, 1.0)) : 0;
}

ColourBar count_bar(const std::string& label, double most) {
  Axis scale{label, 0, 1, {{0, "0"}}};
  for (const double count : {1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0}) {
    if (count < most || count == 1) scale.ticks.push_back({count_share(count, most), fmt::format("{:g}", count)});
  }
  return {std::move(scale), count_colour};
}

cv::Mat map_picture(const Image<float>& shares, int width, int height, Colour (*colour)(double share)) {
  cv::Mat cells(shares.height(), shares.width(), CV_8UC3);
  for (int v{0}; v < cells.rows; ++v) {
    for (int u{0}; u < cells.cols; ++u) {
      const Colour here{colour(shares(u, v))};
      cells.at<cv::Vec3b>(v, u) = {here.red, here.green, here.blue};
    }
  }
  const bool is_smaller{width < cells.cols || height < cells.rows};
  cv::Mat picture;
  cv::resize(cells, picture, {width, height}, 0, 0, is_smaller ? cv::INTER_AREA : cv::INTER_NEAREST);
  return picture;
}

}  // namespace stereogrid::app::figures
