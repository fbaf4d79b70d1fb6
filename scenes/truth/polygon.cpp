// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "truth/truth.hpp"

#include <algorithm>

namespace stereogrid::scenes {
namespace {

double turn(Point2 a, Point2 b, Point2 c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

void extend_hull(Polygon& hull, std::size_t fixed, Point2 point) {
  while (hull.size() >= fixed + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
  hull.push_back(point);
}

/// Keeps the side where a·x + b·y ≥ c.
Polygon clipped(const Polygon& polygon, double a, double b, double c) {
  Polygon kept;
  for (std::size_t i{0}; i < polygon.size(); ++i) {
    const Point2 p{polygon[i]};
    const Point2 q{polygon[(i + 1) % polygon.size()]};
    const double height_p{a * p.x + b * p.y - c};
    const double height_q{a * q.x + b * q.y - c};
    if (height_p >= 0) kept.push_back(p);
    if ((height_p < 0) != (height_q < 0)) {
      const double t{height_p / (height_p - height_q)};
      kept.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
    }
  }
  return kept;
}

double area_of(const Polygon& polygon) {
  double doubled{0};
  for (std::size_t i{2}; i < polygon.size(); ++i) doubled += turn(polygon[0], polygon[i - 1], polygon[i]);
  return doubled / 2;
}

}  // namespace

Polygon convex_hull(std::vector<Point2> points) {
  std::sort(points.begin(), points.end(), [](Point2 a, Point2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  Polygon hull;
  for (const Point2 point : points) extend_hull(hull, 0, point);
  const std::size_t lower{hull.empty() ? 0 : hull.size() - 1};
  for (auto point = points.rbegin(); point != points.rend(); ++point) {
    if (point != points.rbegin()) extend_hull(hull, lower, *point);
  }
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

double area_within(const Polygon& polygon, Point2 low, Point2 high) {
  return area_of(clipped(clipped(clipped(clipped(polygon, 1, 0, low.x), -1, 0, -high.x), 0, 1, low.y), 0, -1, -high.y));
}

}  // namespace stereogrid::scenes
