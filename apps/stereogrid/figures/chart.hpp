// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>

#include "figures/sheet.hpp"

namespace stereogrid::app::figures {

using Function2 = std::function<double(double x, double y)>;

/// A function of two numbers over the axes' ranges, z from 0 to 1, as a surface seen from above its nearest corner
/// (x.from, y.from). The axes are drawn into the picture.
[[nodiscard]] cv::Mat draw_surface(const Function2& function, const Axis& x, const Axis& y, const Axis& z, int width,
                                   int height);

/// The same as a map, with a line at every tenth.
[[nodiscard]] cv::Mat draw_contours(const Function2& function, const Axis& x, const Axis& y, int width, int height);

/// Paper with a faint line at every tick.
[[nodiscard]] cv::Mat empty_chart(const Axis& x, const Axis& y, int width, int height);
void draw_curve(cv::Mat& chart, const std::function<double(double)>& function, const Axis& x, const Axis& y,
                Colour colour);

}  // namespace stereogrid::app::figures
