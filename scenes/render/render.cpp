// SPDX-License-Identifier: Apache-2.0
#include "render/render.hpp"

#include <algorithm>
#include <cmath>

#include "world/numbers.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double ambient{0.62};
constexpr double sunlight{0.5};

struct Sample {
  double grey{0};
  int surface{0};            ///< differs across an edge in the image
  double nearness_per_m{0};  ///< for height fields, which can hide a part of themselves
};

constexpr int first_ground_surface{-1'000'000};

/// Motion of a point on a plane per pixel, to first order.
Vector3 step_on_plane(Vector3 pixel_step, Vector3 ray, Vector3 normal, double depth) {
  constexpr double most_grazing{1e-3};
  double towards{dot(normal, ray)};
  if (towards > -most_grazing) towards = -most_grazing;
  return depth * (pixel_step - (dot(normal, pixel_step) / towards) * ray);
}

double pixel_length(Vector3 axis, Vector3 step_u, Vector3 step_v) {
  const double u{dot(axis, step_u)};
  const double v{dot(axis, step_v)};
  return std::sqrt(u * u + v * v);
}

/// Runs around an upright solid at an even pace, near enough, and needs no arc tangent: −2 … 2.
double around(double x, double y) {
  const double reach{std::abs(x) + std::abs(y)};
  if (reach == 0) return 0;
  return x >= 0 ? y / reach : (y >= 0 ? 2 - y / reach : -2 - y / reach);
}

/// One camera's view of the world: grey levels without noise.
class Shader {
 public:
  Shader(const World& world, const Caster& caster)
      : world_{world},
        caster_{caster},
        camera_{caster.camera()},
        step_u_{(1 / camera_.focal_px) * camera_.right},
        step_v_{(1 / camera_.focal_px) * camera_.down},
        road_seed_{static_cast<std::uint32_t>(scramble(world.seed ^ 0x726f6164U))} {}

  [[nodiscard]] Sample at(double u, double v) const {
    const Hit hit{caster_.trace(u, v)};
    const Vector3 ray{camera_.ray(u, v)};
    if (hit.part == Hit::sky) return sky(ray);
    if (hit.part != Hit::road) return solid(u, v, ray, hit);
    return world_.ground.is_flat() ? road(u, v, ray, hit) : ground(u, v, ray, hit);
  }

 private:
  /// A pale gradient, hardly any texture.
  [[nodiscard]] static Sample sky(Vector3 ray) {
    const double steepness{ray.z / std::sqrt(dot(ray, ray))};
    return {238 - 60 * std::min(1.0, steepness), 4 * Hit::sky};
  }

  [[nodiscard]] Sample road(double u, double v, Vector3 ray, const Hit& hit) const {
    const Vector3 point{camera_.position + hit.depth * ray};
    const Vector3 up{0, 0, 1};
    const double grey{road_grey(world_.road, road_seed_, {point.x, point.y}, step_on_plane(step_u_, ray, up, hit.depth),
                                step_on_plane(step_v_, ray, up, hit.depth))};
    const bool shadow{caster_.in_shadow(u, v, {point.x, point.y, 0})};
    return {grey * (ambient + (shadow ? 0 : sunlight * to_sun.z)), 4 * Hit::road + (shadow ? 1 : 0)};
  }

  /// A height field: its walls have their own texture, areas theirs.
  [[nodiscard]] Sample ground(double u, double v, Vector3 ray, const Hit& hit) const {
    constexpr double above_m{1e-4};  // a ray to the sun starts on the ground, not in it
    const Vector3 point{camera_.position + hit.depth * ray};
    const Vector3 step_u{step_on_plane(step_u_, ray, hit.normal, hit.depth)};
    const Vector3 step_v{step_on_plane(step_v_, ray, hit.normal, hit.depth)};
    const GroundArea* const area{hit.is_wall ? nullptr : area_at(point)};
    HeightField::Crossing ignored;
    const bool shadow{caster_.in_shadow(u, v, point) ||
                      world_.ground.crosses(point + above_m * hit.normal, to_sun, ignored)};
    const double light{ambient + (shadow ? 0 : sunlight * std::max(0.0, dot(hit.normal, to_sun)))};
    double grey{light *
                (hit.is_wall ? wall_grey(point, hit.normal, step_u, step_v) : level_grey(area, point, step_u, step_v))};
    if (area != nullptr && area->mirrors_sky) grey = 0.3 * grey + 0.7 * sky({ray.x, ray.y, -ray.z}).grey;
    const int surface{hit.is_wall ? -1 - (hit.normal.x != 0 ? 1 : 0)
                                  : (area == nullptr ? 0 : 1 + static_cast<int>(area - world_.areas.data()))};
    return {grey, first_ground_surface + 2 * surface + (shadow ? 1 : 0), 1 / hit.depth};
  }

  [[nodiscard]] const GroundArea* area_at(Vector3 point) const {
    const auto found = std::ranges::find_if(world_.areas, [point](const GroundArea& area) {
      return point.x >= area.low.x && point.x <= area.high.x && point.y >= area.low.y && point.y <= area.high.y;
    });
    return found == world_.areas.end() ? nullptr : &*found;
  }

  [[nodiscard]] double level_grey(const GroundArea* area, Vector3 point, Vector3 step_u, Vector3 step_v) const {
    const SurfacePoint at{point.x, point.y, pixel_length({1, 0, 0}, step_u, step_v),
                          pixel_length({0, 1, 0}, step_u, step_v)};
    return area == nullptr ? ground_grey(road_seed_, at) : surface_grey(area->material, road_seed_, at, 0);
  }

  [[nodiscard]] double wall_grey(Vector3 point, Vector3 normal, Vector3 step_u, Vector3 step_v) const {
    constexpr Material earth{Pattern::plain, 110, 15, 0.8};
    const Vector3 level{-normal.y, normal.x, 0};
    const SurfacePoint at{dot(level, point), point.z, pixel_length(level, step_u, step_v),
                          pixel_length({0, 0, 1}, step_u, step_v)};
    return surface_grey(earth, road_seed_ + (normal.x != 0 ? 7 : 8), at, 0);
  }

  [[nodiscard]] Sample solid(double u, double v, Vector3 ray, const Hit& hit) const {
    const PlacedPart& placed{caster_.parts()[static_cast<std::size_t>(hit.part)]};
    const Vector3 world_point{camera_.position + hit.depth * ray};
    const bool low{placed.body->label == TruthLabel::low};
    const bool shadow{low && caster_.in_shadow(u, v, world_point)};
    const double facing{std::max(0.0, dot(hit.normal, turned_into(placed, to_sun)))};
    const double light{ambient + (shadow ? 0 : sunlight * facing)};
    const double grey{texture(placed, world_point, ray, hit)};
    return {grey * light, 4 * hit.part + (shadow ? 1 : 0) + (hit.normal.z > 0.999 ? 2 : 0)};
  }

  [[nodiscard]] double texture(const PlacedPart& placed, Vector3 world_point, Vector3 ray, const Hit& hit) const {
    const Vector3 half{placed.part->solid.half};
    const Vector3 local{turned_into(placed, world_point - placed.centre)};
    const Vector3 local_ray{turned_into(placed, ray)};
    const Vector3 step_u{step_on_plane(turned_into(placed, step_u_), local_ray, hit.normal, hit.depth)};
    const Vector3 step_v{step_on_plane(turned_into(placed, step_v_), local_ray, hit.normal, hit.depth)};
    if (std::abs(hit.normal.z) > 0.999) {
      // Pavements are laid out in the world, so that their pieces join without a seam.
      const bool joined{placed.body->label == TruthLabel::low};
      const Vector3 at{joined ? world_point : local};
      const SurfacePoint point{at.x, at.y, pixel_length({1, 0, 0}, step_u, step_v),
                               pixel_length({0, 1, 0}, step_u, step_v)};
      return surface_grey(placed.part->material, joined ? road_seed_ : placed.texture_seed, point, half.y);
    }
    const Shape shape{placed.part->solid.shape};
    const bool round{shape == Shape::cylinder || shape == Shape::ellipsoid};
    const double flat{std::sqrt(hit.normal.x * hit.normal.x + hit.normal.y * hit.normal.y)};
    const Vector3 level{-hit.normal.y / flat, hit.normal.x / flat, 0};
    const double a{round ? around(local.x, local.y) * 0.8 * std::max(half.x, half.y) : dot(level, local)};
    const auto face =
        static_cast<std::uint32_t>(round ? 0 : (hit.normal.x != 0 ? 1 : 2) + (hit.normal.x + hit.normal.y > 0 ? 2 : 0));
    const SurfacePoint point{a, local.z, pixel_length(level, step_u, step_v), pixel_length({0, 0, 1}, step_u, step_v)};
    return surface_grey(placed.part->material, placed.texture_seed + 1000 * face, point, half.z);
  }

  const World& world_;
  const Caster& caster_;
  const Camera& camera_;
  Vector3 step_u_;
  Vector3 step_v_;
  std::uint32_t road_seed_;
};

/// Pixels beside an edge are the mean of four samples.
double smoothed(const Shader& shader, int u, int v) {
  double sum{0};
  for (const double dv : {-0.25, 0.25}) {
    for (const double du : {-0.25, 0.25}) sum += shader.at(u + du, v + dv).grey;
  }
  return sum / 4;
}

bool beside_edge(const Image<Sample>& samples, int u, int v, double largest_step_per_m) {
  const Sample here{samples(u, v)};
  const auto differs = [&](const Sample& other) {
    return other.surface != here.surface || std::abs(other.nearness_per_m - here.nearness_per_m) > largest_step_per_m;
  };
  return (u > 0 && differs(samples(u - 1, v))) || (v > 0 && differs(samples(u, v - 1))) ||
         (u + 1 < samples.width() && differs(samples(u + 1, v))) ||
         (v + 1 < samples.height() && differs(samples(u, v + 1)));
}

std::uint8_t expose(double grey, const Sensor& sensor, std::uint64_t pixel) {
  const double noise{sensor.noise_grey * gaussian(scramble(sensor.seed ^ scramble(pixel)))};
  return static_cast<std::uint8_t>(std::clamp(sensor.gain * grey + noise, 0.0, 255.0) + 0.5);
}

}  // namespace

Image<std::uint8_t> render(const World& world, const Caster& caster, const Sensor& sensor) {
  const Shader shader{world, caster};
  const int width{caster.camera().width_px};
  const int height{caster.camera().height_px};
  Image<Sample> samples{width, height};
  for_rows(height, [&](int v) {
    for (int u{0}; u < width; ++u) samples(u, v) = shader.at(u, v);
  });
  constexpr double camera_m{0.25};  // the lowest: level ground seen from it changes by 1/(f·h) per row
  const double largest_step_per_m{1.5 / (caster.camera().focal_px * camera_m)};
  Image<std::uint8_t> picture{width, height};
  for_rows(height, [&](int v) {
    for (int u{0}; u < width; ++u) {
      const double grey{beside_edge(samples, u, v, largest_step_per_m) ? smoothed(shader, u, v) : samples(u, v).grey};
      picture(u, v) = expose(grey, sensor, static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(width) + u);
    }
  });
  return picture;
}

}  // namespace stereogrid::scenes
