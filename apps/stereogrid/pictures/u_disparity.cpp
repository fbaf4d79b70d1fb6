// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pictures/drawing.hpp"
#include "pictures/picture.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::app {
namespace {

constexpr int tick_px{5};

void draw_tick(cv::Mat& canvas, int x, int y, int length) {
  cv::line(canvas, {x, y}, {x + length, y}, scalar(palette::ink));
}

/// Row of the canvas at a disparity.
int row_of(const Box& box, double disparity, int disparities) {
  return box.y + static_cast<int>(std::lround((disparity + 0.5) * box.height / disparities));
}

void draw_disparity_axis(cv::Mat& canvas, const Box& box, int disparities) {
  const int step{disparities > 100 ? 20 : 10};
  for (int d{0}; d < disparities; d += step) {
    const int y{row_of(box, d, disparities)};
    draw_tick(canvas, box.x - 1 - tick_px, y, tick_px);
    draw_text(canvas, box.x - 4 - tick_px, y + 5, fmt::format("{}", d), palette::ink, Align::right, 0.4);
  }
}

void draw_depth_axis(cv::Mat& canvas, const Box& box, int disparities, const Rig& rig) {
  const int x{box.x + box.width};
  int lowest_free{box.y + box.height + 12};
  for (const double depth_m : {2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 15.0, 20.0, 40.0, 80.0}) {
    const int y{row_of(box, rig.focal_px * rig.baseline_m / depth_m, disparities)};
    if (y > box.y + box.height || y + 5 > lowest_free) continue;
    draw_tick(canvas, x, y, tick_px);
    draw_text(canvas, x + tick_px + 3, y + 5, fmt::format("{:g} m", depth_m), palette::ink, Align::left, 0.4);
    lowest_free = y - 9;
  }
}

cv::Mat shades_of(const Image<float>& occupancy) {
  cv::Mat grey(occupancy.height(), occupancy.width(), CV_8UC1);
  for (int d{0}; d < grey.rows; ++d) {
    for (int u{0}; u < grey.cols; ++u) grey.at<std::uint8_t>(d, u) = grey_of(occupancy(u, d));
  }
  return grey;
}

}  // namespace

void draw_u_disparity(cv::Mat& canvas, const Box& box, const FrameResult& result, const Rig& rig) {
  const Image<float>& occupancy{result.stages.occupancy_smooth};
  const cv::Mat grey{shades_of(occupancy)};
  cv::Mat large;
  cv::resize(grey, large, {box.width, box.height}, 0, 0, cv::INTER_NEAREST);
  cv::Mat part{canvas(cv::Rect{box.x, box.y, box.width, box.height})};
  cv::cvtColor(large, part, cv::COLOR_GRAY2RGB);
  frame_box(canvas, box);
  draw_disparity_axis(canvas, box, occupancy.height());
  draw_depth_axis(canvas, box, occupancy.height(), rig);
}

std::vector<std::uint8_t> u_disparity_jpeg(const FrameResult& result) {
  constexpr int quality{90};
  return io::encode_jpeg(view_of(shades_of(result.stages.occupancy_smooth)), quality);
}

}  // namespace stereogrid::app
