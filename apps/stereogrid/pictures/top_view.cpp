// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pictures/top_view.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace stereogrid::app {

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
