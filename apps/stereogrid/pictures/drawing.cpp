// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pictures/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace stereogrid::app {
namespace {

constexpr int font{cv::FONT_HERSHEY_SIMPLEX};

cv::Point aligned(int x, int y, const std::string& text, Align align, double size) {
  if (align == Align::left) return {x, y};
  int below{0};
  const int width{cv::getTextSize(text, font, size, 1, &below).width};
  return {x - (align == Align::centre ? width / 2 : width), y};
}

}  // namespace

void draw_text(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour, Align align, double size) {
  cv::putText(canvas, text, aligned(x, y, text, align, size), font, size, scalar(colour), 1, cv::LINE_AA);
}

void draw_text_on_picture(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour, Align align) {
  constexpr double size{0.42};
  const cv::Point start{aligned(x, y, text, align, size)};
  cv::putText(canvas, text, start, font, size, scalar(palette::paper), 4, cv::LINE_AA);
  cv::putText(canvas, text, start, font, size, scalar(colour), 1, cv::LINE_AA);
}

void fill_box(cv::Mat& canvas, const Box& box, Colour colour) {
  cv::rectangle(canvas, cv::Rect{box.x, box.y, box.width, box.height}, scalar(colour), cv::FILLED);
}

void frame_box(cv::Mat& canvas, const Box& box) {
  cv::rectangle(canvas, cv::Rect{box.x - 1, box.y - 1, box.width + 2, box.height + 2}, scalar(palette::frame), 1);
}

std::uint8_t grey_of(float occupancy) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(1 - occupancy, 0.0F, 1.0F)));
}

Colour colour_of_direction(double direction_rad) {
  // three cosines, 120° apart: every hue once around, all of them visible on black and on white
  const auto share = [&](double turn) {
    const double wave{0.5 + 0.5 * std::cos(direction_rad - turn)};
    return static_cast<std::uint8_t>(std::lround(20 + 220 * wave));
  };
  constexpr double third{2 * std::numbers::pi / 3};
  return {share(std::numbers::pi), share(std::numbers::pi + third), share(std::numbers::pi - third)};
}

TopView::TopView(const Box& box, const GridGeometry& grid)
    : box_{box},
      x_max_m_{grid.x_min_m + grid.nx * grid.cell_size_m},
      y_max_m_{grid.y_min_m + grid.ny * grid.cell_size_m},
      px_per_m_{box.height / (grid.nx * grid.cell_size_m)} {}

cv::Point TopView::at(double x_m, double y_m) const {
  return {box_.x + static_cast<int>(std::lround((y_max_m_ - y_m) * px_per_m_)),
          box_.y + static_cast<int>(std::lround((x_max_m_ - x_m) * px_per_m_))};
}

std::vector<double> ruler_marks(double from_m, double to_m, double length_m) {
  const double step_m{length_m > 60 ? 20.0 : length_m > 12 ? 5.0 : 1.0};
  std::vector<double> marks;
  const auto last{static_cast<long>(std::floor(to_m / step_m))};
  for (auto i{static_cast<long>(std::ceil(from_m / step_m))}; i <= last; ++i) {
    marks.push_back(static_cast<double>(i) * step_m);
  }
  return marks;
}

void draw_rulers(cv::Mat& part, const TopView& view, const Rig& rig) {
  const double far_m{view.far_m()};
  const double left{rig.cx_px / rig.focal_px};
  const double right{(rig.width_px - rig.cx_px) / rig.focal_px};
  const cv::Scalar colour{scalar(palette::ruler)};
  cv::line(part, view.at(0, 0), view.at(far_m, left * far_m), colour, 1, cv::LINE_AA);
  cv::line(part, view.at(0, 0), view.at(far_m, -right * far_m), colour, 1, cv::LINE_AA);
  for (const double range_m : ruler_marks(0, 1.5 * far_m, far_m)) {
    const int radius{static_cast<int>(std::lround(range_m * view.px_per_m()))};
    cv::ellipse(part, view.at(0, 0), {radius, radius}, 0, -90 - std::atan(left) * 57.29577951308232,
                -90 + std::atan(right) * 57.29577951308232, colour, 1, cv::LINE_AA);
  }
}

}  // namespace stereogrid::app
