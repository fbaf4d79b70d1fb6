// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "pictures/drawing.hpp"

namespace stereogrid::app {
namespace {

constexpr float moving_above_mps{1.0F};
constexpr float moving_occupancy{0.6F};
constexpr double arrow_s{1.0};          // arrows end at the position after this time
constexpr float elevation_sigmas{2};    // smaller elevations may be noise
constexpr float elevation_min_m{0.1F};  // a kerb's

Colour colour_of_cell(const FrameResult& result, int ix, int iy) {
  const float p{result.vehicle.occupancy(ix, iy)};
  const float vx{result.vehicle.velocity_x(ix, iy)};
  const float vy{result.vehicle.velocity_y(ix, iy)};
  if (p > moving_occupancy && std::hypot(vx, vy) > moving_above_mps) return colour_of_direction(std::atan2(vy, vx));
  if (p < 0.5F && !result.elevation_m.empty()) {
    const float z_m{result.elevation_m(ix, iy)};
    if (std::abs(z_m) > std::max(elevation_min_m, elevation_sigmas * result.elevation_sigma_m(ix, iy))) {
      return mix(colour_of_elevation(z_m), palette().unknown, 2 * p);
    }
  }
  return colour_of_occupancy(p);
}

cv::Mat draw_cells(const FrameResult& result) {
  const GridGeometry& grid{result.vehicle.geometry};
  cv::Mat cells(grid.nx, grid.ny, CV_8UC3);
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Colour colour{colour_of_cell(result, ix, iy)};
      cells.at<cv::Vec3b>(grid.nx - 1 - ix, grid.ny - 1 - iy) = {colour.red, colour.green, colour.blue};
    }
  }
  return cells;
}

/// Field of view and distances.
void draw_rulers(Canvas& canvas, const TopView& view, const GridGeometry& grid, const Rig& rig) {
  constexpr int pieces{48};
  const double far_m{view.far_m()};
  const auto [right, left]{horizontal_view(rig)};
  const Stroke stroke{palette().ring, 1};
  const Pose2 camera{camera_place(rig)};
  const auto at = [&](double x_m, double y_m) {
    const Point2 place{camera * Point2{x_m, y_m}};
    return view.at(place.x, place.y);
  };
  for (const double side : {left, right}) canvas.line({at(0, 0), at(far_m, std::tan(side) * far_m)}, stroke);
  for (const double range_m : ruler_marks(0, 1.5 * far_m, grid.nx * grid.cell_size_m)) {
    Points arc;
    for (int i{0}; i <= pieces; ++i) {
      const double angle{right + (left - right) * i / pieces};
      arc.push_back(at(range_m * std::cos(angle), range_m * std::sin(angle)));
    }
    canvas.line(arc, stroke);
  }
}

void draw_axes(Canvas& canvas, const Box& box, const TopView& view, const GridGeometry& grid) {
  constexpr double tick_px{6};
  const double length_m{grid.nx * grid.cell_size_m};
  const double x_end_m{grid.x_min_m + length_m};
  const double y_end_m{grid.y_min_m + grid.ny * grid.cell_size_m};
  const double left{double(box.x)};
  const double bottom{double(box.y) + box.height};
  const Palette& use{palette()};
  for (const double x_m : ruler_marks(grid.x_min_m, x_end_m, length_m)) {
    const double y{view.at(x_m, 0).y};
    canvas.line({{left - tick_px, y}, {left, y}}, {use.ink});
    canvas.text({left - tick_px - 3, y + 5}, fmt::format("{:g}", x_m), {.colour = use.ink, .align = Align::right});
  }
  for (const double y_m : ruler_marks(grid.y_min_m, y_end_m, length_m)) {
    const double x{view.at(0, y_m).x};
    canvas.line({{x, bottom}, {x, bottom + tick_px}}, {use.ink});
    canvas.text({x, bottom + tick_px + 15}, fmt::format("{:g}", y_m), {.colour = use.ink, .align = Align::centre});
  }
  canvas.text({left - 42, box.y + box.height / 2.0}, "x, ahead (m)",
              {.colour = use.ink, .align = Align::centre, .upwards = true});
  canvas.text({left + box.width / 2.0, bottom + 42}, "y, to the left (m)", {.colour = use.ink, .align = Align::centre});
}

// The outline: closed around an object, a line along a boundary or an edge.
void draw_outline(Canvas& canvas, const TopView& view, const Obstacle& obstacle) {
  Points points;
  for (const Point2& point : obstacle.outline) points.push_back(view.at(point.x, point.y));
  draw_lines(canvas, {points}, stroke_of(obstacle));
}

}  // namespace

void draw_grid(Canvas& canvas, const Box& box, const FrameResult& result) {
  const GridGeometry& grid{result.vehicle.geometry};
  const Box inside{0, 0, box.width, box.height};
  const TopView view{inside, grid};
  const std::vector<Obstacle> obstacles{shown_obstacles(result)};
  canvas.begin_part(box);
  canvas.image(inside, draw_cells(result), false);
  for (const Rig& rig : rigs_of(result)) draw_rulers(canvas, view, grid, rig);
  for (const Obstacle& obstacle : obstacles) draw_outline(canvas, view, obstacle);
  for (const Obstacle& obstacle : obstacles) {
    if (!obstacle.moving) continue;
    draw_arrow(canvas, view.at(obstacle.x_m, obstacle.y_m),
               view.at(obstacle.x_m + arrow_s * obstacle.vx_mps, obstacle.y_m + arrow_s * obstacle.vy_mps),
               colour_of(obstacle));
  }
  Labels labels{canvas, {box.width, box.height}};
  for (const Obstacle& obstacle : obstacles)
    labels.add(obstacle, view.at(obstacle.x_m, obstacle.y_m) + cv::Point2d{0, 6});
  canvas.end_part();
  frame_box(canvas, box);
  draw_axes(canvas, box, TopView{box, grid}, grid);
}

namespace {

/// A bar of colours, whose labels stand below it at even distances.
template <class ColourOf>
void draw_bar(Canvas& canvas, const Box& box, const std::vector<std::string>& labels, ColourOf colour_of_share) {
  cv::Mat ramp(1, box.width, CV_8UC3);
  for (int i{0}; i < box.width; ++i) {
    const Colour colour{colour_of_share(i / (box.width - 1.0))};
    ramp.at<cv::Vec3b>(0, i) = {colour.red, colour.green, colour.blue};
  }
  canvas.image(box, ramp, true);
  frame_box(canvas, box);
  for (std::size_t i{0}; i < labels.size(); ++i) {
    const Align align{i == 0 ? Align::left : i + 1 == labels.size() ? Align::right : Align::centre};
    canvas.text({box.x + box.width * double(i) / (double(labels.size()) - 1), box.y + box.height + 18.0}, labels[i],
                {.colour = palette().ink, .align = align});
  }
}

void draw_wheel(Canvas& canvas, cv::Point2d centre) {
  constexpr int sectors{48};
  constexpr double outer_px{34};
  constexpr double inner_px{17};
  constexpr double step{2 * std::numbers::pi / sectors};
  const auto at = [&](double angle, double radius) {
    return centre + radius * cv::Point2d{-std::sin(angle), -std::cos(angle)};
  };
  for (int i{0}; i < sectors; ++i) {
    const double from{(i - 0.5) * step};
    const double to{(i + 0.7) * step};  // the next one covers the seam
    canvas.fill({at(from, inner_px), at(from, outer_px), at(to, outer_px), at(to, inner_px)},
                colour_of_direction(i * step));
  }
  const Colour ink{palette().ink};
  canvas.text(centre + cv::Point2d{0, -outer_px - 5}, "ahead", {.colour = ink, .align = Align::centre});
  canvas.text(centre + cv::Point2d{0, outer_px + 17}, "back", {.colour = ink, .align = Align::centre});
  canvas.text(centre + cv::Point2d{-outer_px - 6, 5}, "left", {.colour = ink, .align = Align::right});
  canvas.text(centre + cv::Point2d{outer_px + 6, 5}, "right", {.colour = ink});
}

}  // namespace

void draw_grid_legend(Canvas& canvas, const Box& box) {
  constexpr int bar_width{240};
  constexpr int bar_height{14};
  const Palette& use{palette()};
  draw_bar(canvas, {box.x, box.y + 4, bar_width, bar_height}, {"free", "unknown", "occupied"}, colour_of_occupancy);
  draw_bar(canvas, {box.x, box.y + 62, bar_width, bar_height}, {"≤ −0.5 m", "elevation", "≥ 0.5 m"},
           [](double share) { return colour_of_elevation(share - 0.5); });
  const double from{box.x + bar_width + 30.0};
  double y{box.y + 16.0};
  for (const auto& [stroke, text] : {std::pair{Stroke{use.object, outline_px}, "object"},
                                     {Stroke{use.boundary, outline_px}, "boundary"},
                                     {Stroke{use.drop, drop_px}, "edge of a drop"}}) {
    canvas.line({{from, y - 5}, {from + 30, y - 5}}, stroke);
    canvas.text({from + 40, y}, text, {.colour = use.ink});
    y += 28;
  }
  draw_arrow(canvas, {from, y - 5}, {from + 30, y - 5}, use.ink);
  canvas.text({from + 40, y}, "motion in 1 s", {.colour = use.ink});
  draw_wheel(canvas, {box.x + box.width - 90.0, box.y + 60.0});
}

}  // namespace stereogrid::app
