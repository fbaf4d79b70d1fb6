// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "stereogrid/frame.hpp"

namespace stereogrid::scenes {

/// Corners counter-clockwise.
using Polygon = std::vector<Point2>;

/// The smallest convex polygon around some points.
[[nodiscard]] Polygon convex_hull(std::vector<Point2> points);

/// Area of the convex polygon within a rectangle.
[[nodiscard]] double area_within(const Polygon& polygon, Point2 low, Point2 high);

}  // namespace stereogrid::scenes
