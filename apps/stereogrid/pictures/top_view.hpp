// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "pictures/drawing.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid::app {

/// The vehicle frame on the canvas: x up, y to the left. `box` shows the whole grid.
class TopView {
 public:
  TopView(const Box& box, const GridGeometry& grid);

  [[nodiscard]] cv::Point at(double x_m, double y_m) const;
  [[nodiscard]] double px_per_m() const { return px_per_m_; }
  [[nodiscard]] double far_m() const { return x_max_m_; }

 private:
  Box box_;
  double x_max_m_;
  double y_max_m_;
  double px_per_m_;
};

/// The multiples of a round step in [from, to].
[[nodiscard]] std::vector<double> ruler_marks(double from_m, double to_m, double length_m);

/// Field of view and distances.
void draw_rulers(cv::Mat& part, const TopView& view, const Rig& rig);

}  // namespace stereogrid::app
