// SPDX-License-Identifier: Apache-2.0
#include "pictures/drawing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace stereogrid::app {

Colour theme_colour(std::string_view name) {
  const std::string declaration{std::string{name} + ": #"};
  const std::size_t at{theme_css().find(declaration)};  // the light theme is the first
  if (at == std::string_view::npos) throw std::logic_error{std::string{name} + ": not in theme.css"};
  const auto rgb{std::stoul(std::string{theme_css().substr(at + declaration.size(), 6)}, nullptr, 16)};
  return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8), static_cast<std::uint8_t>(rgb)};
}

Palette::Palette() {
  for (std::size_t i{0}; i < headings.size(); ++i) headings[i] = theme_colour(fmt::format("--heading-{}", i));
}

const Palette& palette() {
  static const Palette colours;
  return colours;
}

Colour mix(Colour from, Colour to, double share) {
  const auto between = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + (b - a) * std::clamp(share, 0.0, 1.0)));
  };
  return {between(from.red, to.red), between(from.green, to.green), between(from.blue, to.blue)};
}

Colour colour_of_occupancy(double occupancy) {
  const Palette& use{palette()};
  return occupancy < 0.5 ? mix(use.free, use.unknown, 2 * occupancy)
                         : mix(use.unknown, use.occupied, 2 * occupancy - 1);
}

Colour colour_of_elevation(double elevation_m) {
  constexpr double full_m{0.5};
  const Palette& use{palette()};
  return mix(use.level, elevation_m < 0 ? use.below : use.above, std::sqrt(std::abs(elevation_m) / full_m));
}

Colour colour_of_direction(double direction_rad) {
  const auto& headings{palette().headings};
  const double count{static_cast<double>(headings.size())};
  const double turns{direction_rad / (2 * std::numbers::pi)};
  const double at{std::min((turns - std::floor(turns)) * count, std::nextafter(count, 0.0))};
  const auto i{static_cast<std::size_t>(at)};
  return mix(headings[i], headings[(i + 1) % headings.size()], at - static_cast<double>(i));
}

Colour colour_of(const Obstacle& obstacle) {
  if (obstacle.moving) return colour_of_direction(std::atan2(obstacle.vy_mps, obstacle.vx_mps));
  if (obstacle.kind == ObstacleKind::drop) return palette().drop;
  return obstacle.kind == ObstacleKind::object ? palette().object : palette().boundary;
}

Stroke stroke_of(const Obstacle& obstacle) {
  return {colour_of(obstacle), obstacle.kind == ObstacleKind::drop ? drop_px : outline_px,
          obstacle.kind == ObstacleKind::object};
}

cv::Mat occupancy_colours(const Image<float>& occupancy) {
  cv::Mat colours(occupancy.height(), occupancy.width(), CV_8UC3);
  for (int v{0}; v < colours.rows; ++v) {
    for (int u{0}; u < colours.cols; ++u) {
      const Colour colour{colour_of_occupancy(occupancy(u, v))};
      colours.at<cv::Vec3b>(v, u) = {colour.red, colour.green, colour.blue};
    }
  }
  return colours;
}

void fill_box(Canvas& canvas, const Box& box, Colour colour) {
  const double right{double(box.x) + box.width};
  const double bottom{double(box.y) + box.height};
  canvas.fill({{double(box.x), double(box.y)}, {right, double(box.y)}, {right, bottom}, {double(box.x), bottom}},
              colour);
}

void frame_box(Canvas& canvas, const Box& box) {
  const double left{box.x - 0.5};
  const double top{box.y - 0.5};
  const double right{box.x + box.width + 0.5};
  const double bottom{box.y + box.height + 0.5};
  canvas.line({{left, top}, {right, top}, {right, bottom}, {left, bottom}}, {palette().soft, 1, true});
}

void draw_lines(Canvas& canvas, const std::vector<Points>& lines, const Stroke& stroke) {
  constexpr double light{150};  // luma
  const double luma{0.299 * stroke.colour.red + 0.587 * stroke.colour.green + 0.114 * stroke.colour.blue};
  const Colour halo{luma > light ? palette().ink : palette().card};
  for (const Points& points : lines) canvas.line(points, {halo, stroke.width_px + 2, stroke.is_closed});
  for (const Points& points : lines) canvas.line(points, stroke);
}

void draw_arrow(Canvas& canvas, cv::Point2d from, cv::Point2d to, Colour colour) {
  constexpr double head_px{12};
  const double length_px{std::max(cv::norm(to - from), 1e-6)};
  const cv::Point2d along{(to - from) * (std::min(head_px, length_px / 2) / length_px)};
  const cv::Point2d side{-0.5 * along.y, 0.5 * along.x};
  const cv::Point2d neck{to - along};
  draw_lines(canvas, {{from, neck}, {neck + side, to, neck - side, neck + side}}, {colour, outline_px + 1});
  canvas.fill({neck + side, to, neck - side}, colour);
}

void Labels::add(const Obstacle& obstacle, cv::Point2d at) {
  const std::string text{obstacle.moving
                             ? fmt::format("{}: {:.1f} m/s", obstacle.id, std::hypot(obstacle.vx_mps, obstacle.vy_mps))
                             : fmt::format("{}", obstacle.id)};
  const double half{text_width(text, text_px) / 2 + halo_px};
  if (at.x < 0 || at.x >= view_.width || at.y < 0 || at.y >= view_.height + text_px) return;
  at.x = std::clamp(at.x, half, std::max(half, view_.width - half));
  at.y = std::clamp(at.y, text_px, view_.height - 5.0);
  const cv::Rect2d covered{at.x - half, at.y - text_px, 2 * half, text_px + 2};
  if (std::ranges::any_of(covered_, [&](const cv::Rect2d& other) { return (other & covered).area() > 0; })) return;
  covered_.push_back(covered);
  canvas_.text(at, text, {.colour = palette().ink, .size_px = text_px, .align = Align::centre, .halo_px = halo_px});
}

std::vector<Obstacle> shown_obstacles(const FrameResult& result) {
  std::vector<Obstacle> shown;
  std::ranges::copy_if(result.obstacles, std::back_inserter(shown), &Obstacle::confirmed);
  std::ranges::stable_sort(shown, {}, [](const Obstacle& obstacle) {
    return std::pair{!obstacle.moving, std::hypot(obstacle.x_m, obstacle.y_m)};
  });
  return shown;
}

TopView::TopView(const Box& box, const GridGeometry& grid)
    : box_{box},
      x_max_m_{grid.x_min_m + grid.nx * grid.cell_size_m},
      y_max_m_{grid.y_min_m + grid.ny * grid.cell_size_m},
      px_per_m_{box.height / (grid.nx * grid.cell_size_m)} {}

cv::Point2d TopView::at(double x_m, double y_m) const {
  return {box_.x + (y_max_m_ - y_m) * px_per_m_, box_.y + (x_max_m_ - x_m) * px_per_m_};
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

}  // namespace stereogrid::app
