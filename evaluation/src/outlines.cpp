// SPDX-License-Identifier: Apache-2.0
#include "outlines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stereogrid::evaluation {
namespace {

double distance_to_edge(Point2 a, Point2 b, Point2 p) {
  const Point2 d{b.x - a.x, b.y - a.y};
  const double t{std::clamp(((p.x - a.x) * d.x + (p.y - a.y) * d.y) / std::max(d.x * d.x + d.y * d.y, 1e-9), 0.0, 1.0)};
  return std::hypot(p.x - a.x - t * d.x, p.y - a.y - t * d.y);
}

double distance_to_edges(std::span<const Point2> outline, bool closed, Point2 point) {
  double smallest{std::numeric_limits<double>::infinity()};
  for (std::size_t i{0}; i < outline.size(); ++i) {
    const bool last{i + 1 == outline.size()};
    if (last && !closed && i > 0) break;  // a single point is an edge to itself
    smallest = std::min(smallest, distance_to_edge(outline[i], outline[last ? 0 : i + 1], point));
  }
  return smallest;
}

}  // namespace

std::vector<Point2> corners_of(const Pose2& centre, double length_m, double width_m) {
  const double c{std::cos(centre.yaw_rad)};
  const double s{std::sin(centre.yaw_rad)};
  const double l{length_m / 2};
  const double w{width_m / 2};
  std::vector<Point2> corners;
  for (const Point2 p : {Point2{l, w}, Point2{-l, w}, Point2{-l, -w}, Point2{l, -w}}) {
    corners.push_back({centre.x_m + c * p.x - s * p.y, centre.y_m + s * p.x + c * p.y});
  }
  return corners;
}

double area_of(std::span<const Point2> polygon) {
  if (polygon.size() < 3) return 0;
  double twice{0};
  Point2 before{polygon.back()};
  for (const Point2 point : polygon) {
    twice += before.x * point.y - before.y * point.x;
    before = point;
  }
  return std::abs(twice) / 2;
}

bool holds(std::span<const Point2> polygon, Point2 point) {
  constexpr double level{1e-12};  // avoids a division by zero for horizontal edges
  bool inside{false};
  for (std::size_t i{0}; i < polygon.size(); ++i) {
    const Point2 a{polygon[i]};
    const Point2 b{polygon[i + 1 == polygon.size() ? 0 : i + 1]};
    if ((a.y > point.y) == (b.y > point.y)) continue;
    if (point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y + level) + a.x) inside = !inside;
  }
  return inside;
}

bool is_near(std::span<const Point2> outline, bool closed, Point2 point, double reach_m) {
  if (closed && outline.size() > 2 && holds(outline, point)) return true;
  return distance_to_edges(outline, closed, point) <= reach_m;
}

double share_near(std::span<const Point2> outline, bool closed, std::span<const Point2> points, double reach_m) {
  if (points.empty()) return 0;
  const auto near{
      std::ranges::count_if(points, [&](Point2 point) { return is_near(outline, closed, point, reach_m); })};
  return static_cast<double>(near) / static_cast<double>(points.size());
}

OutlineShape shape_of(std::span<const Point2> outline, bool closed) {
  constexpr double same_m{1e-6};
  constexpr double turn_rad{30 * std::numbers::pi / 180};
  std::vector<Point2> points;
  for (const Point2 p : outline) {
    if (points.empty() || std::hypot(p.x - points.back().x, p.y - points.back().y) > same_m) points.push_back(p);
  }
  OutlineShape shape{points.size(), 0, 0};
  if (points.empty()) return shape;
  const std::size_t edges{closed ? points.size() : points.size() - 1};
  const auto edge = [&](std::size_t i) {
    const Point2 a{points[i % points.size()]};
    const Point2 b{points[(i + 1) % points.size()]};
    return Point2{b.x - a.x, b.y - a.y};
  };
  for (std::size_t i{0}; i < edges; ++i) {
    const Point2 a{edge(i)};
    const Point2 b{edge(i + 1)};
    shape.length_m += std::hypot(a.x, a.y);
    if (i + 1 == edges && !closed) break;
    if (std::abs(std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y)) > turn_rad) ++shape.turns;
  }
  return shape;
}

Slopes slopes_of(std::span<const Point2> outline) {
  constexpr double ahead_min_m{0.1};
  Slopes slopes{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Point2 p : outline) {
    const double slope{p.y / std::max(p.x, ahead_min_m)};
    slopes = {std::min(slopes.least, slope), std::max(slopes.most, slope)};
  }
  return slopes;
}

double nearest_on_ray(std::span<const Point2> polygon, double slope) {
  double nearest{std::numeric_limits<double>::infinity()};
  for (std::size_t i{0}; i < polygon.size(); ++i) {
    const Point2 a{polygon[i]};
    const Point2 b{polygon[i + 1 == polygon.size() ? 0 : i + 1]};
    const double beside_a{a.y - slope * a.x};
    const double beside_b{b.y - slope * b.x};
    if ((beside_a > 0) == (beside_b > 0)) continue;
    const double x{std::lerp(a.x, b.x, beside_a / (beside_a - beside_b))};
    if (x > 0) nearest = std::min(nearest, x);
  }
  return nearest;
}

double distance_m(std::span<const Point2> polygon, Point2 point) {
  if (polygon.size() > 2 && holds(polygon, point)) return 0;
  return distance_to_edges(polygon, true, point);
}

}  // namespace stereogrid::evaluation
