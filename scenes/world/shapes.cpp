// SPDX-License-Identifier: Apache-2.0
#include "world/shapes.hpp"

#include <algorithm>
#include <cmath>

#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

bool enters_box(Vector3 half, Vector3 origin, Vector3 direction, double t_max, Entry& entry) {
  const double half_axis[3]{half.x, half.y, half.z};
  const double from[3]{origin.x, origin.y, origin.z};
  const double along[3]{direction.x, direction.y, direction.z};
  double t_in{0};
  double t_out{t_max};
  int axis_in{-1};
  for (int axis{0}; axis < 3; ++axis) {
    if (along[axis] == 0) {
      if (std::abs(from[axis]) >= half_axis[axis]) return false;
      continue;
    }
    const double near_side{along[axis] > 0 ? -half_axis[axis] : half_axis[axis]};
    const double t_near{(near_side - from[axis]) / along[axis]};
    const double t_far{(-near_side - from[axis]) / along[axis]};
    if (t_near > t_in) {
      t_in = t_near;
      axis_in = axis;
    }
    t_out = std::min(t_out, t_far);
    if (t_in >= t_out) return false;
  }
  if (axis_in < 0) return false;
  const double sign{along[axis_in] > 0 ? -1.0 : 1.0};
  entry = {t_in, {axis_in == 0 ? sign : 0, axis_in == 1 ? sign : 0, axis_in == 2 ? sign : 0}};
  return true;
}

/// Smaller root of a·t² + 2·b·t + c = 0; false where there is none.
bool smaller_root(double a, double b, double c, double& t) {
  const double discriminant{b * b - a * c};
  if (discriminant <= 0 || a == 0) return false;
  t = (-b - std::sqrt(discriminant)) / a;
  return true;
}

bool enters_cylinder(Vector3 half, Vector3 origin, Vector3 direction, double t_max, Entry& entry) {
  const double ox{origin.x / half.x};
  const double oy{origin.y / half.y};
  const double dx{direction.x / half.x};
  const double dy{direction.y / half.y};
  double t{0};
  if (smaller_root(dx * dx + dy * dy, ox * dx + oy * dy, ox * ox + oy * oy - 1, t) && t > 0 && t < t_max &&
      std::abs(origin.z + t * direction.z) <= half.z) {
    const double nx{(ox + t * dx) / half.x};
    const double ny{(oy + t * dy) / half.y};
    const double length{std::sqrt(nx * nx + ny * ny)};
    entry = {t, {nx / length, ny / length, 0}};
    return true;
  }
  if (direction.z == 0) return false;
  const double side{direction.z > 0 ? -1.0 : 1.0};
  t = (side * half.z - origin.z) / direction.z;
  const double px{ox + t * dx};
  const double py{oy + t * dy};
  if (t <= 0 || t >= t_max || px * px + py * py > 1) return false;
  entry = {t, {0, 0, side}};
  return true;
}

/// Swaps the axes along which a wheel and a cylinder lie.
Vector3 upright(Vector3 v) {
  return {v.x, v.z, v.y};
}

bool enters_ellipsoid(Vector3 half, Vector3 origin, Vector3 direction, double t_max, Entry& entry) {
  const Vector3 o{origin.x / half.x, origin.y / half.y, origin.z / half.z};
  const Vector3 d{direction.x / half.x, direction.y / half.y, direction.z / half.z};
  double t{0};
  if (!smaller_root(dot(d, d), dot(o, d), dot(o, o) - 1, t) || t <= 0 || t >= t_max) return false;
  const Vector3 p{o + t * d};
  const Vector3 gradient{p.x / half.x, p.y / half.y, p.z / half.z};
  entry = {t, (1 / std::sqrt(dot(gradient, gradient))) * gradient};
  return true;
}

}  // namespace

bool enters(const Solid& solid, Vector3 origin, Vector3 direction, double t_max, Entry& entry) {
  switch (solid.shape) {
    case Shape::box:
      return enters_box(solid.half, origin, direction, t_max, entry);
    case Shape::cylinder:
      return enters_cylinder(solid.half, origin, direction, t_max, entry);
    case Shape::wheel: {
      const bool hit{enters_cylinder(upright(solid.half), upright(origin), upright(direction), t_max, entry)};
      if (hit) entry.normal = upright(entry.normal);
      return hit;
    }
    default:
      return enters_ellipsoid(solid.half, origin, direction, t_max, entry);
  }
}

bool column_at(const Solid& solid, double x, double y, Column& column) {
  const double a{x / solid.half.x};
  const double b{y / solid.half.y};
  double share{1};  // share of the height
  switch (solid.shape) {
    case Shape::box:
      if (std::max(std::abs(a), std::abs(b)) > 1) return false;
      break;
    case Shape::cylinder:
      if (a * a + b * b > 1) return false;
      break;
    case Shape::wheel:
      if (std::max(std::abs(a), std::abs(b)) > 1) return false;
      share = std::sqrt(1 - a * a);
      break;
    default:
      if (a * a + b * b > 1) return false;
      share = std::sqrt(1 - a * a - b * b);
  }
  column = {-share * solid.half.z, share * solid.half.z};
  return true;
}

std::vector<Point2> outline(const Solid& solid, double bottom_m, double top_m) {
  const Vector3 half{solid.half};
  const double low{std::max(bottom_m, -half.z)};
  const double high{std::min(top_m, half.z)};
  if (low >= high) return {};
  const double widest{std::clamp(0.0, low, high) / half.z};
  double scale{solid.shape == Shape::ellipsoid || solid.shape == Shape::wheel ? std::sqrt(1 - widest * widest) : 1};
  if (solid.shape == Shape::box || solid.shape == Shape::wheel) {
    const double x{scale * half.x};
    return {{x, half.y}, {-x, half.y}, {-x, -half.y}, {x, -half.y}};
  }
  constexpr int corners{16};
  scale /= direction_of(pi / corners).cosine;
  std::vector<Point2> polygon;
  for (int i{0}; i < corners; ++i) {
    const Direction corner{direction_of(2 * pi * i / corners)};
    polygon.push_back({scale * half.x * corner.cosine, scale * half.y * corner.sine});
  }
  return polygon;
}

}  // namespace stereogrid::scenes
