// SPDX-License-Identifier: Apache-2.0
#include "pictures/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include <fmt/format.h>

namespace stereogrid::app {
namespace {

constexpr int font{cv::FONT_HERSHEY_SIMPLEX};

cv::Point aligned(int x, int y, const std::string& text, Align align, double size) {
  if (align == Align::left) return {x, y};
  int below{0};
  const int width{cv::getTextSize(text, font, size, 1, &below).width};
  return {x - (align == Align::centre ? width / 2 : width), y};
}

}  // namespace

void draw_text(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour, Align align, double size) {
  cv::putText(canvas, text, aligned(x, y, text, align, size), font, size, scalar(colour), 1, cv::LINE_AA);
}

void draw_text_on_picture(cv::Mat& canvas, int x, int y, const std::string& text, Colour colour, Align align) {
  constexpr double size{0.42};
  const cv::Point start{aligned(x, y, text, align, size)};
  cv::putText(canvas, text, start, font, size, scalar(palette::paper), 4, cv::LINE_AA);
  cv::putText(canvas, text, start, font, size, scalar(colour), 1, cv::LINE_AA);
}

void fill_box(cv::Mat& canvas, const Box& box, Colour colour) {
  cv::rectangle(canvas, cv::Rect{box.x, box.y, box.width, box.height}, scalar(colour), cv::FILLED);
}

void frame_box(cv::Mat& canvas, const Box& box) {
  cv::rectangle(canvas, cv::Rect{box.x - 1, box.y - 1, box.width + 2, box.height + 2}, scalar(palette::frame), 1);
}

std::uint8_t grey_of(float occupancy) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(1 - occupancy, 0.0F, 1.0F)));
}

Colour colour_of_direction(double direction_rad) {
  // three cosines, 120° apart: every hue once around, all of them visible on black and on white
  const auto share = [&](double turn) {
    const double wave{0.5 + 0.5 * std::cos(direction_rad - turn)};
    return static_cast<std::uint8_t>(std::lround(20 + 220 * wave));
  };
  constexpr double third{2 * std::numbers::pi / 3};
  return {share(std::numbers::pi), share(std::numbers::pi + third), share(std::numbers::pi - third)};
}

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

namespace {

constexpr double nearest_m{1};  // before it, lines would run out of any image
constexpr double near_m{10};    // static obstacles within it are boxes
constexpr int shift{4};         // fixed-point bits of OpenCV's pixels

// Projection of points over the road into the level image.
class View {
 public:
  View(const Rig& level_rig, const Ground& ground) : rig_{level_rig}, ground_{ground} {}

  /// In 1/16 px; none: too near.
  [[nodiscard]] std::optional<cv::Point> at(Point2 place, double height_m) const {
    if (place.x < nearest_m) return {};
    // the road's normal g in the camera's frame, g·X = height of the camera over it; docs/method.md §1.2
    const double level{std::cos(ground_.pitch_rad)};
    const double right{-place.y / place.x};
    const double down{((ground_.height_m - height_m) / place.x - level * std::sin(ground_.roll_rad) * right -
                       std::sin(ground_.pitch_rad)) /
                      (level * std::cos(ground_.roll_rad))};
    return cv::Point{fixed(rig_.cx_px + rig_.focal_px * right), fixed(rig_.cy_px + rig_.focal_px * down)};
  }

 private:
  static int fixed(double pixel) { return static_cast<int>(std::lround(pixel * (1 << shift))); }

  const Rig& rig_;
  const Ground& ground_;
};

std::vector<Point2> corners_of(const Obstacle& obstacle) {
  const Pose2 box{obstacle.x_m, obstacle.y_m, obstacle.yaw_rad};
  const Point2 half{obstacle.length_m / 2, obstacle.width_m / 2};
  return {box * half, box * Point2{half.x, -half.y}, box * Point2{-half.x, -half.y}, box * Point2{-half.x, half.y}};
}

// Clockwise corners: a side faces the camera if it has the camera on its left.
bool faces_camera(Point2 from, Point2 to) {
  return from.y * to.x - from.x * to.y < 0;
}

void draw_base(cv::Mat& image, const View& view, const std::vector<Point2>& places, bool is_box, Colour colour) {
  const std::size_t sides{places.size() - (is_box || places.empty() ? 0 : 1)};
  for (std::size_t i{0}; i < sides; ++i) {
    const Point2 to{places[(i + 1) % places.size()]};
    const auto begin = view.at(places[i], 0);
    const auto end = view.at(to, 0);
    if (!begin || !end || (is_box && !faces_camera(places[i], to))) continue;
    cv::line(image, *begin, *end, scalar(colour), 1, cv::LINE_AA, shift);
  }
}

// The outline on the road and at the obstacle's height, and upright lines at its corners.
void draw_upright(cv::Mat& image, const View& view, const std::vector<Point2>& places, bool is_box,
                  const Obstacle& obstacle, Colour colour) {
  std::vector<cv::Point> base;
  std::vector<cv::Point> top;
  for (const Point2& place : places) {
    const auto below = view.at(place, 0);
    const auto above = view.at(place, obstacle.height_m);
    if (!below || !above) return;
    base.push_back(*below);
    top.push_back(*above);
  }
  for (const auto& line : {base, top}) cv::polylines(image, line, is_box, scalar(colour), 1, cv::LINE_AA, shift);
  for (std::size_t i{0}; i < base.size(); ++i) {
    if (is_box || i == 0 || i + 1 == base.size()) {
      cv::line(image, base[i], top[i], scalar(colour), 1, cv::LINE_AA, shift);
    }
  }
}

void draw_edge(cv::Mat& image, const View& view, const Obstacle& obstacle) {
  std::vector<cv::Point> line;
  for (const Point2& place : obstacle.outline) {
    if (const auto at = view.at(place, 0)) line.push_back(*at);
  }
  cv::polylines(image, line, false, scalar(palette::drop), 3, cv::LINE_AA, shift);
}

}  // namespace

void draw_obstacles_in_image(cv::Mat& image, const FrameResult& result, const Rig& level_rig) {
  const View view{level_rig, result.ground};
  for (const Obstacle& obstacle : result.obstacles) {
    if (!obstacle.confirmed || obstacle.coasting) continue;
    const Colour colour{obstacle.moving ? colour_of_direction(std::atan2(obstacle.vy_mps, obstacle.vx_mps))
                                        : palette::obstacle};
    if (obstacle.kind == ObstacleKind::drop) {
      draw_edge(image, view, obstacle);
      continue;
    }
    const bool is_box{obstacle.kind == ObstacleKind::object};
    const std::vector<Point2> places{is_box ? corners_of(obstacle)
                                            : std::vector<Point2>{obstacle.outline.begin(), obstacle.outline.end()}};
    if (obstacle.moving || (is_box && std::hypot(obstacle.x_m, obstacle.y_m) < near_m)) {
      draw_upright(image, view, places, is_box, obstacle, colour);
    } else {
      draw_base(image, view, places, is_box, colour);
    }
    const auto place = view.at({obstacle.x_m, obstacle.y_m}, obstacle.height_m);
    if (!obstacle.moving || !place) continue;
    draw_text_on_picture(image, place->x >> shift, (place->y >> shift) - 4,
                         fmt::format("{:.1f} m/s", std::hypot(obstacle.vx_mps, obstacle.vy_mps)), colour,
                         Align::centre);
  }
}

}  // namespace stereogrid::app
