// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "outlines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

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

double distance_m(std::span<const Point2> polygon, Point2 point) {
  if (polygon.size() > 2 && holds(polygon, point)) return 0;
  return distance_to_edges(polygon, true, point);
}

}  // namespace stereogrid::evaluation
