// SPDX-License-Identifier: Apache-2.0
#include "world/world.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid::scenes {
namespace {

// std::floor is a library call on plain x86-64.
std::int64_t floor_of(double x) {
  const auto truncated = static_cast<std::int64_t>(x);
  return truncated - (x < static_cast<double>(truncated) ? 1 : 0);
}

/// In [−1, 1], hashed at the corners of a unit lattice and smooth between them.
double lattice_noise(double x, double y, std::uint32_t seed) {
  const std::int64_t ix{floor_of(x)};
  const std::int64_t iy{floor_of(y)};
  const double fx{x - static_cast<double>(ix)};
  const double fy{y - static_cast<double>(iy)};
  const double wx{fx * fx * (3 - 2 * fx)};
  const double wy{fy * fy * (3 - 2 * fy)};
  const std::uint32_t corner{static_cast<std::uint32_t>(ix) * 0x9e3779b1U +
                             static_cast<std::uint32_t>(iy) * 0x85ebca77U + seed};
  const auto value = [corner](std::uint32_t step) {
    return static_cast<double>(static_cast<std::int32_t>(scramble(corner + step))) * 0x1p-31;
  };
  const double near_row{value(0) + wx * (value(0x9e3779b1U) - value(0))};
  const double far_row{value(0x85ebca77U) + wx * (value(0x9e3779b1U + 0x85ebca77U) - value(0x85ebca77U))};
  return near_row + wy * (far_row - near_row);
}

/// Weight of a lattice by the pixels of its step: 1 from two on, 0 up to one.
double visible(double pixels) {
  const double t{std::clamp(pixels - 1, 0.0, 1.0)};
  return t * t * (3 - 2 * t);
}

constexpr double finest_m{0.012};

/// Octaves of noise, each with the same amplitude: about a standard deviation of 1 where six are visible.
/// Lattices are `stretch`, a power of two, times longer along a. Halving is exact, so it takes the place of divisions.
double octaves(const SurfacePoint& at, double coarsest_m, double stretch, std::uint32_t seed) {
  double a{at.a / (coarsest_m * stretch)};
  double b{at.b / coarsest_m};
  double pixels_a{coarsest_m * stretch / at.footprint_a};
  double pixels_b{coarsest_m / at.footprint_b};
  double sum{0};
  for (double lattice{coarsest_m}; lattice > finest_m; lattice /= 2) {
    const double weight{visible(pixels_a) * visible(pixels_b)};
    if (!(weight > 0)) break;  // nor is a finer one
    sum += weight * lattice_noise(a, b, scramble(++seed));
    a *= 2;
    b *= 2;
    pixels_a /= 2;
    pixels_b /= 2;
  }
  return sum;
}

/// Share of the pixel that lies between two edges.
double covered(double x, double low, double high, double footprint) {
  const double half{footprint / 2};
  return std::clamp((std::min(high, x + half) - std::max(low, x - half)) / footprint, 0.0, 1.0);
}

/// Share of the pixel covered by stripes that repeat every `period`; their mean where a pixel holds several.
double covered_by_stripes(double x, double period, double low, double high, double footprint) {
  const double in_period{x - period * static_cast<double>(floor_of(x / period))};
  const double mean{(high - low) / period};
  if (footprint >= period) return mean;
  const double sharp{covered(in_period, low, high, footprint) +
                     covered(in_period, low - period, high - period, footprint) +
                     covered(in_period, low + period, high + period, footprint)};
  return sharp + (mean - sharp) * std::clamp(2 * footprint / period - 1, 0.0, 1.0);
}

double mix(double from, double to, double share) {
  return from + share * (to - from);
}

double bricks(const SurfacePoint& at, double length, double height, double joint) {
  const double course{static_cast<double>(floor_of(at.b / height) & 1)};
  const double upright{covered_by_stripes(at.a + course * length / 2, length, length - joint, length, at.footprint_a)};
  const double level{covered_by_stripes(at.b, height, height - joint, height, at.footprint_b)};
  return upright + level - upright * level;
}

double windows(const SurfacePoint& at, double margin) {
  return covered_by_stripes(at.a, 2.6, 0.7 - margin, 1.9 + margin, at.footprint_a) *
         covered_by_stripes(at.b, 2.9, 1.0 - margin, 2.3 + margin, at.footprint_b);
}

}  // namespace

double surface_grey(const Material& material, std::uint32_t seed, const SurfacePoint& point, double half_height) {
  const double noise{octaves(point, material.coarsest_m, 1, seed)};
  const double grey{material.grey + material.contrast * noise};
  const SurfacePoint from_bottom{point.a, point.b + half_height, point.footprint_a, point.footprint_b};
  switch (material.pattern) {
    case Pattern::plain:
      return grey;
    case Pattern::bricks:
      return mix(grey, material.grey * 1.25, 0.6 * bricks(point, 0.5, 0.2, 0.03));
    case Pattern::slabs:
      return mix(grey, material.grey * 0.6, bricks(point, 0.6, 0.6, 0.02));
    case Pattern::planks:
      return mix(grey, material.grey * 0.45, covered_by_stripes(from_bottom.b, 0.16, 0.14, 0.16, point.footprint_b));
    case Pattern::lettering:
      return mix(grey, material.grey * 0.4,
                 covered(from_bottom.b, 1.0, 1.45, point.footprint_b) *
                     covered_by_stripes(point.a, 0.5, 0.1, 0.38, point.footprint_a) *
                     covered(point.a, -1.2, 1.3, point.footprint_a));
    case Pattern::windows:
      return mix(mix(grey, 215, windows(from_bottom, 0.1)), 50 + 9 * noise, windows(from_bottom, 0));
    default:
      return mix(grey, 45 + 8 * noise,
                 covered(point.b, -half_height + 0.06, half_height - 0.1, point.footprint_b) *
                     covered_by_stripes(point.a + 0.05, 0.95, 0.1, 0.95, point.footprint_a));
  }
}

namespace {

struct RoadPlace {
  double along{0};
  double left{0};
  Direction tangent;
};

RoadPlace place_on(const Road& road, Point2 point) {
  const double left{point.y - road.centre_left_m};
  if (road.curvature_per_m == 0) return {point.x, left, {}};
  const double radius{1 / road.curvature_per_m};
  const double to_centre{radius - left};
  const double distance{std::sqrt(point.x * point.x + to_centre * to_centre)};
  const double sign{radius > 0 ? 1.0 : -1.0};
  const Direction tangent{sign * to_centre / distance, sign * point.x / distance};
  const double s{tangent.sine};
  // arc sine by its series: libm's differ, and a stroke of paint may be a little long far away
  const double turn{s * (1 + s * s * (1 / 6.0 + s * s * (3 / 40.0 + s * s * (15 / 336.0))))};
  return {radius * turn, radius - sign * distance, tangent};
}

double painted(const Road& road, const SurfacePoint& at) {
  double share{0};
  for (const Paint& stroke : road.paint) {
    const double across{covered(at.b, stroke.left_min_m, stroke.left_max_m, at.footprint_b)};
    if (across == 0) continue;
    double along{covered(at.a, stroke.along_min_m, stroke.along_max_m, at.footprint_a)};
    if (stroke.period_m > 0) along *= covered_by_stripes(at.a, stroke.period_m, 0, stroke.dash_m, at.footprint_a);
    share = std::max(share, across * along);
  }
  return share;
}

double length_along(Direction axis, Vector3 step_u, Vector3 step_v) {
  const double u{axis.cosine * step_u.x + axis.sine * step_u.y};
  const double v{axis.cosine * step_v.x + axis.sine * step_v.y};
  return std::sqrt(u * u + v * v);
}

}  // namespace

double road_grey(const Road& road, std::uint32_t seed, Point2 point, Vector3 step_u, Vector3 step_v) {
  const RoadPlace place{place_on(road, point)};
  const SurfacePoint at{place.along, place.left, length_along(place.tangent, step_u, step_v),
                        length_along({-place.tangent.sine, place.tangent.cosine}, step_u, step_v)};
  // At grazing angles a pixel is far longer than wide: tyre tracks and seams along the road keep texture there.
  const double noise{1.2 * octaves(at, 0.4, 1, seed) + 0.9 * octaves(at, 0.4, 4, seed + 100) +
                     0.9 * octaves(at, 0.8, 16, seed + 200) + 0.6 * octaves(at, 0.4, 64, seed + 300)};
  const double asphalt{100 + 11 * noise};
  return mix(asphalt, 205 + 8 * noise, 0.9 * painted(road, at));
}

double ground_grey(std::uint32_t seed, const SurfacePoint& point) {
  const double noise{1.0 * octaves(point, 3.2, 1, seed) + 0.8 * octaves(point, 0.8, 4, seed + 100) +
                     0.8 * octaves(point, 0.8, 16, seed + 200) + 0.5 * octaves(point, 0.4, 64, seed + 300)};
  return 105 + 10 * noise;
}

}  // namespace stereogrid::scenes
