// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/frame.hpp"

namespace stereogrid::scenes {

struct Vector3 {
  double x{0};
  double y{0};
  double z{0};

  friend Vector3 operator+(Vector3 a, Vector3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vector3 operator-(Vector3 a, Vector3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Vector3 operator*(double k, Vector3 a) { return {k * a.x, k * a.y, k * a.z}; }
};

[[nodiscard]] inline double dot(Vector3 a, Vector3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

enum class Shape { box, cylinder, wheel, ellipsoid };

/// A convex solid around its own origin that just fits in [−half, half]: a box, an upright elliptic cylinder, one that
/// lies along y, or an ellipsoid.
struct Solid {
  Shape shape{Shape::box};
  Vector3 half;
};

/// Entry point of a ray into a solid, at origin + t · direction.
struct Entry {
  double t{0};
  Vector3 normal;  ///< outward, unit length
};

/// Finds the entry with 0 < t < t_max, in the solid's own frame. A ray that starts inside has none.
[[nodiscard]] bool enters(const Solid& solid, Vector3 origin, Vector3 direction, double t_max, Entry& entry);

/// Lowest and highest point of a solid over a place, in its own frame.
struct Column {
  double low{0};
  double high{0};
};
/// false: the solid is not over that place.
[[nodiscard]] bool column_at(const Solid& solid, double x, double y, Column& column);

/// Outline of the part of the solid between two heights (relative to its centre), seen from above, in its own frame;
/// empty where there is nothing between them. Round solids get the 16-gon around them.
[[nodiscard]] std::vector<Point2> outline(const Solid& solid, double bottom_m, double top_m);

}  // namespace stereogrid::scenes
