// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "world/numbers.hpp"
#include "world/shapes.hpp"

namespace stereogrid::scenes {

enum class Pattern { plain, bricks, windows, planks, slabs, car_windows, lettering };

/// Appearance of a surface: a mean grey level, noise of every size around it, and a pattern.
struct Material {
  Pattern pattern{Pattern::plain};
  double grey{120};
  double contrast{15};  ///< about the standard deviation where six octaves are visible
  double coarsest_m{0.8};
};

/// A place on a surface in metres along two directions, and how much of it a pixel covers in each.
struct SurfacePoint {
  double a{0};
  double b{0};
  double footprint_a{0};
  double footprint_b{0};
};

/// Grey level of a surface before light falls on it. Detail finer than a pixel is faded out, so that both cameras (and
/// the next frame) see the same signal. `half_height` is half the size of the solid along b.
[[nodiscard]] double surface_grey(const Material& material, std::uint32_t seed, const SurfacePoint& point,
                                  double half_height);

/// Paint on the road, along and to the left of its centre line. A period of 0 is a solid stroke.
struct Paint {
  double along_min_m{-1e4};
  double along_max_m{1e4};
  double left_min_m{0};
  double left_max_m{0};
  double dash_m{0};
  double period_m{0};
};

/// The plane z = 0 with the markings of a road whose centre line is an arc that starts along +x at (0, centre_left_m).
struct Road {
  double centre_left_m{0};
  double curvature_per_m{0};
  std::vector<Paint> paint;
};

/// Grey level of the road at a world point. `step_u`, `step_v`: how far the point moves per pixel.
[[nodiscard]] double road_grey(const Road& road, std::uint32_t seed, Point2 point, Vector3 step_u, Vector3 step_v);

/// Grey level of open ground: the road's texture with coarser octaves, which remain visible far away.
[[nodiscard]] double ground_grey(std::uint32_t seed, const SurfacePoint& point);

}  // namespace stereogrid::scenes
