// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid::evaluation {

/// Corners of a box, counter-clockwise from the front left one. `centre`: its middle and the heading of its length.
[[nodiscard]] std::vector<Point2> corners_of(const Pose2& centre, double length_m, double width_m);

// An outline is a polygon; where it is not closed, the line through its points.

/// m²; 0 of fewer than three points.
[[nodiscard]] double area_of(std::span<const Point2> polygon);
/// True if the point is inside, by the number of edges beyond it.
[[nodiscard]] bool holds(std::span<const Point2> polygon, Point2 point);
/// Inside (where it is closed), or within `reach_m` of an edge.
[[nodiscard]] bool is_near(std::span<const Point2> outline, bool closed, Point2 point, double reach_m);
/// Share of the points that it is near to; 0 where there are none.
[[nodiscard]] double share_near(std::span<const Point2> outline, bool closed, std::span<const Point2> points,
                                double reach_m);
/// Shape of an outline, without repeated points.
struct OutlineShape {
  std::size_t corners{0};
  std::size_t turns{0};  ///< corners of more than 30°
  double length_m{0};
};
[[nodiscard]] OutlineShape shape_of(std::span<const Point2> outline, bool closed);
/// Slopes y/x of the rays from the origin between which an outline lies, and x at which a ray first meets it; infinite:
/// nowhere.
struct Slopes {
  double least;
  double most;
};
[[nodiscard]] Slopes slopes_of(std::span<const Point2> outline);
[[nodiscard]] double nearest_on_ray(std::span<const Point2> polygon, double slope);
/// From a point to the nearest place of a polygon; 0 inside.
[[nodiscard]] double distance_m(std::span<const Point2> polygon, Point2 point);

}  // namespace stereogrid::evaluation
