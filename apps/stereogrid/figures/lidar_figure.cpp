// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "figures/figures.hpp"
#include "figures/panels.hpp"
#include "top_view.hpp"

namespace stereogrid::app::figures {
namespace {

constexpr Colour low_colour{200, 202, 206};
constexpr Colour upright_colour{200, 40, 30};
constexpr Colour high_colour{70, 130, 200};
// what the scores against lidar count as an obstacle
constexpr double upright_from_m{0.3};
constexpr double upright_to_m{1.8};

Colour colour_of(const LidarPoint& point) {
  if (point.height_m < upright_from_m) return low_colour;
  return point.height_m < upright_to_m ? upright_colour : high_colour;
}

Panel scan_panel(const std::vector<LidarPoint>& scan, const GridGeometry& grid, const Rig& rig) {
  Panel panel{empty_grid_panel("(c) lidar, from above", grid, GridSize::large)};
  const TopView view{{0, 0, panel.picture.cols, panel.picture.rows}, grid};
  // obstacles last, so that nothing hides them
  for (const Colour layer : {low_colour, high_colour, upright_colour}) {
    for (const LidarPoint& point : scan) {
      const Colour colour{colour_of(point)};
      if (colour.red != layer.red) continue;
      const cv::Point at{view.at(point.x_m, point.y_m)};
      if (!cv::Rect{1, 1, panel.picture.cols - 2, panel.picture.rows - 2}.contains(at)) continue;
      fill_box(panel.picture, {at.x, at.y, 2, 2}, colour);
    }
  }
  draw_rulers(panel.picture, view, rig);
  panel.keys = {{upright_colour, fmt::format("{:g} to {:g} m above the road", upright_from_m, upright_to_m)},
                {low_colour, "lower"},
                {high_colour, "higher"}};
  return panel;
}

}  // namespace

std::optional<io::RgbImage> figure_9(const Material& material) {
  if (!material.scan) return std::nullopt;
  const FrameResult& result{material.moment().result};
  const GridGeometry& grid{result.vehicle_grid};
  Sheet sheet{"Figure 9. Beside the lidar",
              {fmt::format("{}, frame {}. Lines: what the camera can see, and every 5 m.", material.input,
                           material.moment().frame.name)}};
  sheet.add_row({grid_panel("(a) frame alone", result.observed, grid, material.rig, GridSize::large),
                 grid_panel("(b) filtered", result.occupancy, grid, material.rig, GridSize::large),
                 scan_panel(*material.scan, grid, material.rig)});
  return sheet.draw();
}

}  // namespace stereogrid::app::figures
