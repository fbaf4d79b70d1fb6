// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <optional>

#include "pictures/drawing.hpp"
#include "stereogrid/level_mapping.hpp"

namespace stereogrid::app {
namespace {

constexpr double nearest_m{1};  // before it, lines would run out of any image
constexpr double near_m{10};    // static obstacles within it are boxes

// Projection of points over the road into the level image.
class View {
 public:
  /// `scale`: px of the canvas per px of the image.
  View(const Rig& level_rig, const Ground& ground, double scale) : rig_{level_rig}, ground_{ground}, scale_{scale} {}

  [[nodiscard]] Point2 in_camera(Point2 in_vehicle) const { return inverse(camera_place(rig_)) * in_vehicle; }
  /// None: too near.
  [[nodiscard]] std::optional<cv::Point2d> at(Point2 in_vehicle, double height_m) const {
    const Point2 place{in_camera(in_vehicle)};
    if (place.x < nearest_m) return {};
    // the road's normal g in the camera's frame, g·X = height of the camera over it; docs/method.md §1.2
    const double level{std::cos(ground_.pitch_rad)};
    const double right{-place.y / place.x};
    const double down{((ground_.height_m - height_m) / place.x - level * std::sin(ground_.roll_rad) * right -
                       std::sin(ground_.pitch_rad)) /
                      (level * std::cos(ground_.roll_rad))};
    return cv::Point2d{scale_ * (rig_.cx_px + 0.5 + rig_.focal_px * right),
                       scale_ * (rig_.cy_px + 0.5 + rig_.focal_px * down)};
  }

 private:
  const Rig& rig_;
  const Ground& ground_;
  double scale_;
};

std::vector<Point2> corners_of(const Obstacle& obstacle) {
  const Pose2 box{obstacle.x_m, obstacle.y_m, obstacle.yaw_rad};
  const Point2 half{obstacle.length_m / 2, obstacle.width_m / 2};
  return {box * half, box * Point2{half.x, -half.y}, box * Point2{-half.x, -half.y}, box * Point2{-half.x, half.y}};
}

// Clockwise corners: a side faces the camera if it has the camera on its left.
bool faces_camera(const View& view, Point2 first, Point2 last) {
  const Point2 from{view.in_camera(first)};
  const Point2 to{view.in_camera(last)};
  return from.y * to.x - from.x * to.y < 0;
}

std::vector<Points> base_of(const View& view, const std::vector<Point2>& places, bool is_box) {
  std::vector<Points> lines;
  const std::size_t sides{places.size() - (is_box || places.empty() ? 0 : 1)};
  for (std::size_t i{0}; i < sides; ++i) {
    const Point2 to{places[(i + 1) % places.size()]};
    const auto begin = view.at(places[i], 0);
    const auto end = view.at(to, 0);
    if (begin && end && (!is_box || faces_camera(view, places[i], to))) lines.push_back({*begin, *end});
  }
  return lines;
}

// The outline on the road and at the obstacle's height, and upright lines at its corners.
std::vector<Points> upright_of(const View& view, const std::vector<Point2>& places, bool is_box, double height_m) {
  Points base;
  Points top;
  for (const Point2& place : places) {
    const auto below = view.at(place, 0);
    const auto above = view.at(place, height_m);
    if (!below || !above) return {};
    base.push_back(*below);
    top.push_back(*above);
  }
  std::vector<Points> lines;
  for (std::size_t i{0}; i < base.size(); ++i) {
    if (is_box || i == 0 || i + 1 == base.size()) lines.push_back({base[i], top[i]});
  }
  for (Points* const line : {&base, &top}) {
    if (is_box) line->push_back(line->front());
    lines.push_back(std::move(*line));
  }
  return lines;
}

std::vector<Points> lines_of(const View& view, const Obstacle& obstacle) {
  const bool is_box{obstacle.kind == ObstacleKind::object};
  const std::vector<Point2> places{is_box ? corners_of(obstacle)
                                          : std::vector<Point2>{obstacle.outline.begin(), obstacle.outline.end()}};
  const bool is_near{is_box && std::hypot(obstacle.x_m, obstacle.y_m) < near_m};
  return obstacle.moving || is_near ? upright_of(view, places, is_box, obstacle.height_m)
                                    : base_of(view, places, is_box);
}

}  // namespace

void draw_obstacles_in_image(Canvas& canvas, const Box& box, const CameraImage& image) {
  const Rig level_rig{LevelMapping{image.seen.rig}.level_rig()};
  const View view{level_rig, image.seen.ground, double(box.width) / level_rig.width_px};
  const std::vector<Obstacle> obstacles{shown_obstacles(image.result)};
  canvas.begin_part(box);
  for (const Obstacle& obstacle : obstacles) {
    if (obstacle.coasting) continue;
    Stroke stroke{stroke_of(obstacle)};
    stroke.is_closed = false;  // boxes are closed by their lines
    draw_lines(canvas, lines_of(view, obstacle), stroke);
  }
  Labels labels{canvas, {box.width, box.height}};
  for (const Obstacle& obstacle : obstacles) {
    const double height_m{obstacle.kind == ObstacleKind::drop ? 0 : obstacle.height_m};
    const auto place = view.at({obstacle.x_m, obstacle.y_m}, height_m);
    if (place && !obstacle.coasting) labels.add(obstacle, *place - cv::Point2d{0, 6});
  }
  canvas.end_part();
}

}  // namespace stereogrid::app
