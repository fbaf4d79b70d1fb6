// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "layouts/terrain.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {
namespace {

constexpr Material bark{Pattern::plain, 80, 20, 0.2};

/// The feature's place and width, the latter at most `widest_m`.
Feature narrowed_to(const Feature& feature, double widest_m) {
  Feature narrow{feature};
  const double half_m{std::min(feature.width_m(), widest_m) / 2};
  narrow.right_m = feature.middle_m() - half_m;
  narrow.left_m = feature.middle_m() + half_m;
  return narrow;
}

Part part_of(Shape shape, Vector3 centre, Vector3 half, const Material& material) {
  return {{shape, half}, centre, 0, material};
}

Body made_of(std::string kind, Point2 place, std::vector<Part> parts) {
  Body body;
  body.kind = std::move(kind);
  body.motion.start = {place.x, place.y, 0};
  body.parts = std::move(parts);
  return body;
}

void add_area(Site& site, const Feature& feature, const Material& material, bool mirrors_sky) {
  const Feature area{narrowed_to(feature, site.is_robot ? 0.8 : 2.5)};
  site.world.areas.push_back(
      {{area.at_m, area.right_m}, {area.at_m + area.span_m, area.left_m}, material, mirrors_sky});
}

}  // namespace

void build_paint(Site& site, const Feature& feature) {
  add_area(site, feature, {Pattern::plain, 205, 6, 0.4}, false);
}

void build_puddle(Site& site, const Feature& feature) {
  add_area(site, feature, {Pattern::plain, 60, 5, 0.4}, true);
}

void build_rubble(Site& site, const Feature& feature) {
  const Feature field{narrowed_to(feature, site.is_robot ? 2 : 5)};
  const double smallest_m{std::min(0.03, feature.rise_m)};
  for (int i{0}; i < feature.steps; ++i) {
    const double high_m{site.random.between(smallest_m, feature.rise_m)};
    const double wide_m{high_m * site.random.between(0.6, 1.1)};
    const Point2 place{field.at_m + wide_m + site.random.between(0, field.span_m),
                       site.random.between(field.right_m, field.left_m)};
    const Material rock{Pattern::plain, site.random.between(90, 150), 20, 0.15};
    site.put(made_of("stone", place, {part_of(Shape::ellipsoid, {}, {wide_m, 1.2 * wide_m, high_m}, rock)}));
  }
}

void build_box(Site& site, const Feature& feature) {
  double at_m{feature.at_m};
  if (feature.slope != 0) {
    Feature ramp{feature};
    const double ahead_m{site.is_robot ? 0.8 : 2.5};
    ramp.at_m = std::max(feature.at_m - ahead_m, 0.1);
    ramp.span_m = site.is_robot ? 4 : 12;
    ramp.right_m = -400;
    ramp.left_m = 400;
    build_ramp(site, ramp);
  }
  at_m += feature.span_m / 2;
  site.put(
      make_crate({at_m, feature.middle_m(), 0}, {feature.span_m, 1.3 * feature.span_m, feature.rise_m}, site.random));
}

void build_post(Site& site, const Feature& feature) {
  site.put(make_pole({feature.at_m + 0.08, feature.middle_m(), 0}, feature.rise_m, site.random));
}

void build_barrier(Site& site, const Feature& feature) {
  const double half_m{narrowed_to(feature, site.is_robot ? 1.2 : 4).width_m() / 2};
  const double thick_m{site.is_robot ? 0.02 : 0.06};
  const double middle_m{feature.rise_m + thick_m};
  const Material stripes{Pattern::car_windows, 200, 8, 0.4};
  std::vector<Part> parts{part_of(Shape::box, {0, 0, middle_m}, {thick_m / 2, half_m, thick_m}, stripes)};
  for (const double y : {-half_m, half_m}) {
    parts.push_back(part_of(Shape::cylinder, {0, y, middle_m / 2}, {thick_m, thick_m, middle_m / 2}, bark));
  }
  site.put(made_of("barrier", {feature.at_m + thick_m, feature.middle_m()}, std::move(parts)));
}

void build_branch(Site& site, const Feature& feature) {
  const double half_m{narrowed_to(feature, site.is_robot ? 1.2 : 4).width_m() / 2};
  const double thick_m{site.is_robot ? 0.015 : 0.05};
  site.put(made_of("branch", {feature.at_m + thick_m, feature.middle_m()},
                   {part_of(Shape::wheel, {0, 0, feature.rise_m + thick_m}, {thick_m, half_m, thick_m}, bark)}));
}

void build_desk(Site& site, const Feature& feature) {
  const double half_m{narrowed_to(feature, site.is_robot ? 1 : 2.4).width_m() / 2};
  const double deep_m{feature.span_m / 2};
  const double top_m{feature.rise_m};
  const Material wood{Pattern::plain, 150, 16, 0.4};
  std::vector<Part> parts{part_of(Shape::box, {0, 0, top_m - 0.02}, {deep_m, half_m, 0.02}, wood)};
  for (const double x : {-0.9 * deep_m, 0.9 * deep_m}) {
    for (const double y : {-0.92 * half_m, 0.92 * half_m}) {
      parts.push_back(part_of(Shape::box, {x, y, top_m / 2 - 0.02}, {0.03, 0.03, top_m / 2 - 0.02}, wood));
    }
  }
  site.put(made_of("table", {feature.at_m + deep_m, feature.middle_m()}, std::move(parts)));
}

void build_bridge(Site& site, const Feature& feature) {
  const double half_m{site.is_robot ? 2.0 : 6.0};
  const double thick_m{site.is_robot ? 0.08 : 0.3};
  const double deep_m{feature.span_m / 2};
  const Material concrete{Pattern::plain, 130, 16, 0.8};
  std::vector<Part> parts{
      part_of(Shape::box, {0, 0, feature.rise_m + thick_m}, {deep_m, half_m + 2 * thick_m, thick_m}, concrete)};
  for (const double y : {-half_m, half_m}) {
    parts.push_back(part_of(Shape::box, {0, y, feature.rise_m / 2}, {deep_m, thick_m, feature.rise_m / 2}, concrete));
  }
  site.put(made_of("bridge", {feature.at_m + deep_m, 0}, std::move(parts)));
}

}  // namespace stereogrid::scenes
