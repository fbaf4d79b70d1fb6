// SPDX-License-Identifier: Apache-2.0
#include "pictures/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "stereogrid/level_mapping.hpp"

namespace stereogrid::app {
namespace {

constexpr int margin_px{14};
constexpr int title_height_px{36};
constexpr int caption_height_px{28};
constexpr int u_disparity_height_px{256};
constexpr int camera_width_min_px{1000};
constexpr int camera_width_max_px{1400};

struct Layout {
  int width{0};
  int height{0};
  std::vector<Box> cameras;
  Box u_disparity;  ///< unused with several cameras
  Box grid;
  Box legend;
};

/// Small cameras are enlarged, huge ones reduced.
Box camera_box(const Rig& rig) {
  const double enlarged{std::min(4.0, std::ceil(static_cast<double>(camera_width_min_px) / rig.width_px))};
  const double scale{rig.width_px < camera_width_min_px
                         ? std::min(enlarged, static_cast<double>(camera_width_max_px) / rig.width_px)
                         : std::min(1.0, static_cast<double>(camera_width_max_px) / rig.width_px)};
  return {margin_px + axis_margin_px, title_height_px + caption_height_px,
          std::max(1, static_cast<int>(rig.width_px * scale)), std::max(1, static_cast<int>(rig.height_px * scale))};
}

/// Whole pixels per cell where cells are large enough for it, in at most `height_px`, and no wider than a camera.
Box grid_box(const GridGeometry& grid, int height_px) {
  const double fitting{
      std::min(static_cast<double>(height_px) / grid.nx, static_cast<double>(camera_width_max_px) / grid.ny)};
  const double scale{fitting >= 5 ? std::floor(fitting) : fitting};
  return {0, 0, std::max(1, static_cast<int>(grid.ny * scale)), std::max(1, static_cast<int>(grid.nx * scale))};
}

/// Boxes of several cameras, in the width of one, below each other's captions.
std::vector<Box> camera_boxes(const std::vector<Rig>& rigs) {
  const Box whole{camera_box(rigs.front())};
  if (rigs.size() == 1) return {whole};
  const int columns{rigs.size() <= 4 ? 2 : 3};
  const int width{(whole.width - (columns - 1) * margin_px) / columns};
  std::vector<Box> boxes;
  int y{whole.y};
  int row_height{0};
  for (std::size_t i{0}; i < rigs.size(); ++i) {
    const int column{static_cast<int>(i) % columns};
    if (column == 0 && i > 0) y += std::exchange(row_height, 0) + margin_px + caption_height_px;
    const int height{std::max(1, width * rigs[i].height_px / rigs[i].width_px)};
    boxes.push_back({whole.x + column * (width + margin_px), y, width, height});
    row_height = std::max(row_height, height);
  }
  return boxes;
}

Layout layout_of(const std::vector<Rig>& rigs, const GridGeometry& grid) {
  constexpr int least_height_px{700};  // for a grid that is readable
  Layout layout;
  layout.cameras = camera_boxes(rigs);
  const Box whole{camera_box(rigs.front())};
  int bottom{0};
  for (const Box& box : layout.cameras) bottom = std::max(bottom, box.y + box.height + margin_px);
  if (rigs.size() == 1) {
    layout.u_disparity = {whole.x, bottom + caption_height_px, whole.width, u_disparity_height_px};
    layout.height = layout.u_disparity.y + layout.u_disparity.height + margin_px;
  } else {
    layout.height = std::max(bottom, least_height_px);
  }
  const int right_column{whole.x + whole.width + 2 * axis_margin_px + margin_px};
  layout.grid = grid_box(grid, layout.height - whole.y - axis_below_px - margin_px - legend_height_px);
  layout.grid.x = right_column;
  layout.grid.y = whole.y;
  layout.legend = {right_column, layout.grid.y + layout.grid.height + axis_below_px + margin_px, legend_width_px,
                   legend_height_px};
  layout.width = right_column + std::max(layout.grid.width, legend_width_px) + 2 * margin_px;
  return layout;
}

void draw_title(Canvas& canvas, const StereoFrame& frame, const FrameResult& result) {
  const double pitch_deg{std::round(result.ground.pitch_rad * 572.9577951308232) / 10 + 0.0};  // never −0.0
  canvas.text({margin_px, 25},
              fmt::format("frame {}    t = {:.2f} s    camera height {:.2f} m, pitch {:.1f}°{}", frame.name,
                          static_cast<double>(frame.stamp_ns) * 1e-9, result.ground.height_m, pitch_deg,
                          result.ground.estimated ? "" : " (not measured in this frame)"),
              {.colour = palette().ink, .size_px = title_px});
}

void draw_captions(Canvas& canvas, const Layout& layout, const FrameResult& result) {
  constexpr double above{9};
  const Palette& use{palette()};
  const auto caption = [&](const Box& box, const std::string& text) {
    canvas.text({double(box.x), box.y - above}, text, {.colour = use.soft});
  };
  for (std::size_t i{0}; i < layout.cameras.size(); ++i) {
    const FrameResult& seen{result.cameras.empty() ? result : result.cameras[i]};
    caption(layout.cameras[i], (result.cameras.empty() ? "left camera" : seen.camera_name) +
                                   (LevelMapping{seen.rig}.is_identity() ? "" : ", level"));
  }
  const Box& camera{layout.cameras.front()};
  int x{camera.x + 170};
  for (const auto& [colour, text] : {std::pair{use.upright, "obstacle, P > 0.75"}, {use.road, "road, P < 0.4"}}) {
    fill_box(canvas, {x, camera.y - 22, 14, 14}, mix({160, 160, 160}, colour, 0.5));
    canvas.text({x + 20.0, camera.y - above}, text, {.colour = use.ink});
    x += 190;
  }
  if (result.cameras.empty()) caption(layout.u_disparity, "u-disparity occupancy, columns as above");
  caption(layout.grid, "filtered grid from above");
}

void draw(Canvas& canvas, const Layout& layout, const StereoFrame& frame, const FrameResult& result) {
  fill_box(canvas, {0, 0, layout.width, layout.height}, palette().paper);
  draw_title(canvas, frame, result);
  draw_captions(canvas, layout, result);
  for (std::size_t i{0}; i < layout.cameras.size(); ++i)
    draw_camera(canvas, layout.cameras[i], image_of(frame, result, static_cast<int>(i)));
  if (result.cameras.empty()) draw_u_disparity(canvas, layout.u_disparity, image_of(frame, result, 0));
  draw_grid(canvas, layout.grid, result);
  draw_grid_legend(canvas, layout.legend);
}

}  // namespace

io::RgbImage draw_picture(const StereoFrame& frame, const FrameResult& result) {
  const Layout layout{layout_of(rigs_of(result), result.vehicle.geometry)};
  PixelCanvas canvas{layout.width, layout.height};
  draw(canvas, layout, frame, result);
  return canvas.result();
}

std::string draw_svg(const StereoFrame& frame, const FrameResult& result) {
  const Layout layout{layout_of(rigs_of(result), result.vehicle.geometry)};
  SvgCanvas canvas{layout.width, layout.height};
  draw(canvas, layout, frame, result);
  return canvas.result();
}

}  // namespace stereogrid::app
