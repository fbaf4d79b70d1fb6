// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "pictures/drawing.hpp"

namespace stereogrid::app {
namespace {

constexpr float moving_above_mps{1.0F};
constexpr float moving_occupancy{0.6F};
constexpr double arrow_s{1.0};  // arrows end at the position after this time

cv::Mat draw_cells(const FrameResult& result) {
  const GridGeometry& grid{result.vehicle.geometry};
  cv::Mat cells(grid.nx, grid.ny, CV_8UC3);
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const float p{result.vehicle.occupancy(ix, iy)};
      const float vx{result.vehicle.velocity_x(ix, iy)};
      const float vy{result.vehicle.velocity_y(ix, iy)};
      const std::uint8_t grey{grey_of(p)};
      Colour colour{grey, grey, grey};
      if (p > moving_occupancy && std::hypot(vx, vy) > moving_above_mps)
        colour = colour_of_direction(std::atan2(vy, vx));
      cells.at<cv::Vec3b>(grid.nx - 1 - ix, grid.ny - 1 - iy) = {colour.red, colour.green, colour.blue};
    }
  }
  return cells;
}

void draw_axes(cv::Mat& canvas, const Box& box, const TopView& view, const GridGeometry& grid) {
  const double x_end_m{grid.x_min_m + grid.nx * grid.cell_size_m};
  const double y_end_m{grid.y_min_m + grid.ny * grid.cell_size_m};
  for (const double x_m : ruler_marks(grid.x_min_m, x_end_m, x_end_m)) {
    const int y{view.at(x_m, 0).y};
    cv::line(canvas, {box.x - 6, y}, {box.x - 1, y}, scalar(palette::ink));
    draw_text(canvas, box.x - 9, y + 5, fmt::format("{:g}", x_m), palette::ink, Align::right, 0.4);
  }
  for (const double y_m : ruler_marks(grid.y_min_m, y_end_m, x_end_m)) {
    const int x{view.at(0, y_m).x};
    cv::line(canvas, {x, box.y + box.height}, {x, box.y + box.height + 5}, scalar(palette::ink));
    draw_text(canvas, x, box.y + box.height + 18, fmt::format("{:g}", y_m), palette::ink, Align::centre, 0.4);
  }
}

void draw_arrow(cv::Mat& part, const TopView& view, const Obstacle& obstacle, Colour colour) {
  const cv::Point start{view.at(obstacle.x_m, obstacle.y_m)};
  const cv::Point end{view.at(obstacle.x_m + arrow_s * obstacle.vx_mps, obstacle.y_m + arrow_s * obstacle.vy_mps)};
  const double length_px{std::hypot(end.x - start.x, end.y - start.y)};
  cv::arrowedLine(part, start, end, scalar(palette::paper), 5, cv::LINE_AA, 0, std::min(0.5, 8 / length_px));
  cv::arrowedLine(part, start, end, scalar(colour), 2, cv::LINE_AA, 0, std::min(0.5, 8 / length_px));
}

// The outline: closed around an object, a line along a boundary or an edge.
void draw_obstacle(cv::Mat& part, const TopView& view, const Obstacle& obstacle) {
  std::vector<cv::Point> points;
  for (const Point2& point : obstacle.outline) points.push_back(view.at(point.x, point.y));
  const double speed{std::hypot(obstacle.vx_mps, obstacle.vy_mps)};
  const bool moves{speed > moving_above_mps};
  const bool is_drop{obstacle.kind == ObstacleKind::drop};
  const Colour standing{is_drop ? palette::drop : palette::obstacle};
  const Colour colour{moves ? colour_of_direction(std::atan2(obstacle.vy_mps, obstacle.vx_mps)) : standing};
  cv::polylines(part, points, obstacle.kind == ObstacleKind::object, scalar(colour), moves || is_drop ? 2 : 1,
                cv::LINE_AA);
  if (moves) draw_arrow(part, view, obstacle, colour);
}

void label_obstacle(cv::Mat& part, const TopView& view, const Obstacle& obstacle) {
  const double speed{std::hypot(obstacle.vx_mps, obstacle.vy_mps)};
  const std::string text{speed > moving_above_mps ? fmt::format("{}: {:.1f} m/s", obstacle.id, speed)
                                                  : fmt::format("{}", obstacle.id)};
  const cv::Point place{view.at(obstacle.x_m, obstacle.y_m)};
  if (!cv::Rect{0, 0, part.cols, part.rows}.contains(place)) return;
  draw_text_on_picture(part, std::min(place.x + 6, part.cols - 70), std::clamp(place.y + 4, 14, part.rows - 6), text,
                       palette::ink);
}

}  // namespace

void draw_grid(cv::Mat& canvas, const Box& box, const FrameResult& result, const Rig& rig) {
  const GridGeometry& grid{result.vehicle.geometry};
  cv::Mat part{canvas(cv::Rect{box.x, box.y, box.width, box.height})};
  const cv::Mat cells{draw_cells(result)};
  cv::resize(cells, part, part.size(), 0, 0, box.height < cells.rows ? cv::INTER_AREA : cv::INTER_NEAREST);
  const TopView in_part{{0, 0, box.width, box.height}, grid};
  draw_rulers(part, in_part, rig);
  for (const Obstacle& obstacle : result.obstacles) {
    if (obstacle.confirmed) draw_obstacle(part, in_part, obstacle);
  }
  for (const Obstacle& obstacle : result.obstacles) {
    if (obstacle.confirmed) label_obstacle(part, in_part, obstacle);
  }
  frame_box(canvas, box);
  draw_axes(canvas, box, TopView{box, grid}, grid);
}

void draw_grid_legend(cv::Mat& canvas, const Box& box) {
  constexpr int ramp_width{190};
  const int ramp_y{box.y + 10};
  for (int i{0}; i < ramp_width; ++i) {
    const std::uint8_t grey{grey_of(static_cast<float>(i) / (ramp_width - 1))};
    fill_box(canvas, {box.x + i, ramp_y, 1, 12}, {grey, grey, grey});
  }
  frame_box(canvas, {box.x, ramp_y, ramp_width, 12});
  draw_text(canvas, box.x, ramp_y + 27, "free", palette::ink, Align::left, 0.4);
  draw_text(canvas, box.x + ramp_width / 2, ramp_y + 27, "unknown", palette::ink, Align::centre, 0.4);
  draw_text(canvas, box.x + ramp_width, ramp_y + 27, "occupied", palette::ink, Align::right, 0.4);
  draw_text(canvas, box.x, ramp_y + 48, "outline: obstacle, number, speed", palette::obstacle, Align::left, 0.4);
  draw_text(canvas, box.x, ramp_y + 66, "line: edge of a drop", palette::drop, Align::left, 0.4);
  draw_text(canvas, box.x, ramp_y + 84, "arrow: motion in 1 s", palette::ink, Align::left, 0.4);
  constexpr int radius{24};
  const cv::Point centre{box.x + box.width - 50, box.y + 32};
  for (int dy{-radius}; dy <= radius; ++dy) {
    for (int dx{-radius}; dx <= radius; ++dx) {
      const double distance{std::hypot(dx, dy)};
      if (distance > radius || distance < radius / 2.0) continue;
      fill_box(canvas, {centre.x + dx, centre.y + dy, 1, 1}, colour_of_direction(std::atan2(-dx, -dy)));
    }
  }
  draw_text(canvas, centre.x, centre.y + radius + 18, "moving towards", palette::ink, Align::centre, 0.4);
}

}  // namespace stereogrid::app
