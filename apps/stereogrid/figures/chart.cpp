// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/chart.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "figures/colour_map.hpp"

namespace stereogrid::app::figures {

cv::Mat draw_contours(const Function2& function, const Axis& x, const Axis& y, int width, int height) {
  Image<float> values(width, height);
  for (int row{0}; row < height; ++row) {
    for (int column{0}; column < width; ++column) {
      const double across{x.from + (x.to - x.from) * (column + 0.5) / width};
      const double upwards{y.from + (y.to - y.from) * (height - row - 0.5) / height};
      values(column, row) = static_cast<float>(function(across, upwards));
    }
  }
  cv::Mat picture{map_picture(values, width, height, sequential_colour)};
  const auto band = [&](int column, int row) { return std::floor(10 * static_cast<double>(values(column, row))); };
  for (int row{0}; row + 1 < height; ++row) {
    for (int column{0}; column + 1 < width; ++column) {
      const double here{band(column, row)};
      if (here == band(column + 1, row) && here == band(column, row + 1)) continue;
      picture.at<cv::Vec3b>(row, column) = {palette::paper.red, palette::paper.green, palette::paper.blue};
    }
  }
  return picture;
}

cv::Mat empty_chart(const Axis& x, const Axis& y, int width, int height) {
  cv::Mat chart(height, width, CV_8UC3, cv::Scalar::all(255));
  constexpr Colour faint{225, 226, 228};
  for (const Tick& tick : x.ticks) {
    const int at{along_x(x, tick.at, width)};
    cv::line(chart, {at, 0}, {at, height}, scalar(faint));
  }
  for (const Tick& tick : y.ticks) {
    const int at{along_y(y, tick.at, height)};
    cv::line(chart, {0, at}, {width, at}, scalar(faint));
  }
  return chart;
}

void draw_curve(cv::Mat& chart, const std::function<double(double)>& function, const Axis& x, const Axis& y,
                Colour colour) {
  std::vector<cv::Point> points;
  for (int column{0}; column <= chart.cols; ++column) {
    const double at{x.from + (x.to - x.from) * column / chart.cols};
    points.emplace_back(column, along_y(y, function(at), chart.rows));
  }
  cv::polylines(chart, points, false, scalar(colour), 2, cv::LINE_AA);
}

}  // namespace stereogrid::app::figures
