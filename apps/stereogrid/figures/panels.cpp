// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "figures/panels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "pictures/panels.hpp"
#include "pictures/top_view.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr int image_width_px{560};
constexpr int u_disparity_height_px{220};

/// Small images are enlarged by whole factors, large ones reduced.
int shown_width_px(const Rig& rig) {
  return rig.width_px > image_width_px ? image_width_px + 60 : rig.width_px * (image_width_px / rig.width_px);
}

Axis columns(const Rig& rig) {
  return axis("column u (px)", -0.5, rig.width_px - 0.5);
}

/// Where distances lie among the disparities; what would stand too close to its neighbour is left out.
std::vector<Tick> distances(const Axis& y, const Rig& rig, int height_px) {
  std::vector<Tick> ticks;
  int lowest_free{height_px};
  for (const double depth_m : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0}) {
    const double disparity{rig.focal_px * rig.baseline_m / depth_m};
    const int at{along_y(y, disparity, height_px)};
    if (disparity > y.from || at > lowest_free) continue;
    ticks.push_back({disparity, fmt::format("{:g} m", depth_m)});
    lowest_free = at - 15;
  }
  return ticks;
}

/// Cells as the picture has them: ahead is up, left is left.
Image<float> turned(const Image<float>& cells) {
  Image<float> picture(cells.height(), cells.width());
  for (int iy{0}; iy < cells.height(); ++iy) {
    for (int ix{0}; ix < cells.width(); ++ix) {
      picture(cells.height() - 1 - iy, cells.width() - 1 - ix) = cells(ix, iy);
    }
  }
  return picture;
}

cv::Size picture_size(const GridGeometry& grid, GridSize size) {
  const double fitting{static_cast<double>(size) / std::max(grid.nx, grid.ny)};
  const double cell_px{fitting >= 1 ? std::floor(fitting) : fitting};
  return {std::max(1, static_cast<int>(grid.ny * cell_px)), std::max(1, static_cast<int>(grid.nx * cell_px))};
}

Panel image_panel(std::string title, cv::Mat picture, const Rig& rig) {
  return {std::move(title), std::move(picture), columns(rig), axis("row v (px)", rig.height_px - 0.5, -0.5, 6)};
}

cv::Size shown_size(const Rig& rig) {
  const int width{shown_width_px(rig)};
  return {width, std::max(1, width * rig.height_px / rig.width_px)};
}

}  // namespace

Panel u_disparity_panel(std::string title, const Image<float>& shares, ColourBar bar, const Rig& rig, int disparities) {
  const int rows{shares.height()};
  const int height{rows * std::max(1, (u_disparity_height_px + rows / 2) / rows)};
  const double half_bin{0.5 * disparities / rows};
  Panel panel{std::move(title), map_picture(shares, shown_width_px(rig), height, bar.colour), columns(rig),
              axis("disparity d (px)", disparities - half_bin, -half_bin, 8)};
  panel.right = {"", panel.y.from, panel.y.to, distances(panel.y, rig, height)};
  panel.bar = std::move(bar);
  return panel;
}

Panel count_panel(std::string title, const Image<std::uint16_t>& counts, const Rig& rig, int disparities) {
  const double most{static_cast<double>(*std::max_element(counts.begin(), counts.end()))};
  Image<float> shares(counts.width(), counts.height());
  std::transform(counts.begin(), counts.end(), shares.begin(),
                 [most](std::uint16_t count) { return static_cast<float>(count_share(count, most)); });
  return u_disparity_panel(std::move(title), shares, count_bar("pixels", most), rig, disparities);
}

Panel empty_grid_panel(std::string title, const GridGeometry& grid, GridSize size) {
  const double x_end_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  const double y_end_m{grid.y_min_m + grid.ny * grid.cell_size_m};
  const cv::Size shown{picture_size(grid, size)};
  return {std::move(title), cv::Mat(shown, CV_8UC3, cv::Scalar::all(255)),
          axis("to the left, y (m)", y_end_m, grid.y_min_m, std::clamp(shown.width / 40, 3, 6)),
          axis("ahead, x (m)", grid.x_min_m, x_end_m, std::clamp(shown.height / 25, 3, 6))};
}

Panel cells_panel(std::string title, const Image<float>& shares, Colour (*colour)(double share),
                  const GridGeometry& grid, const Rig& rig, GridSize size) {
  Panel panel{empty_grid_panel(std::move(title), grid, size)};
  const cv::Size shown{panel.picture.size()};
  panel.picture = map_picture(turned(shares), shown.width, shown.height, colour);
  draw_rulers(panel.picture, TopView{{0, 0, shown.width, shown.height}, grid}, rig);
  return panel;
}

Panel grid_panel(std::string title, const Image<float>& occupancy, const GridGeometry& grid, const Rig& rig,
                 GridSize size) {
  Panel panel{cells_panel(std::move(title), occupancy, occupancy_colour, grid, rig, size)};
  panel.bar = occupancy_bar();
  return panel;
}

Panel camera_panel(std::string title, const StereoFrame& frame, const Rig& rig) {
  cv::Mat shown;
  cv::resize(level_image(frame, rig), shown, shown_size(rig), 0, 0, cv::INTER_AREA);
  cv::cvtColor(shown, shown, cv::COLOR_GRAY2RGB);
  return image_panel(std::move(title), shown, rig);
}

Panel overlay_panel(std::string title, const StereoFrame& frame, const FrameResult& result, const Rig& rig) {
  const cv::Size size{shown_size(rig)};
  cv::Mat picture(size, CV_8UC3);
  draw_camera(picture, {0, 0, size.width, size.height}, frame, result, rig);
  return image_panel(std::move(title), picture, rig);
}

Image<std::uint16_t> road_counts(const Image<float>& road_disparity, int rows, int disparities) {
  Image<std::uint16_t> counts(road_disparity.width(), rows);
  for (int v{0}; v < road_disparity.height(); ++v) {
    for (int u{0}; u < road_disparity.width(); ++u) {
      const float disparity{road_disparity(u, v)};
      if (!(disparity > 0)) continue;
      const auto row{std::lround(static_cast<double>(disparity) * rows / disparities)};
      if (row > 0 && row < rows) ++counts(u, static_cast<int>(row));
    }
  }
  return counts;
}

}  // namespace stereogrid::app::figures
