// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <utility>

#include "layouts/terrain.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {
namespace {

Polyline across(const Feature& feature) {
  return between(feature.right_m, feature.left_m);
}

/// Length over which a slope begins or ends.
double rounding_m(const Site& site) {
  return site.is_robot ? 0.3 : 1.0;
}

/// Raised or lowered ground of the feature's length.
void add_step(Site& site, const Feature& feature, double rise_m) {
  const double end_m{feature.at_m + feature.length_m};
  site.relief.add({{{feature.at_m, 0}, {feature.at_m, rise_m}, {end_m, rise_m}, {end_m, 0}}}, across(feature));
}

}  // namespace

void build_flat(Site&, const Feature&) {}

void build_ramp(Site& site, const Feature& feature) {
  const double bend_m{rounding_m(site)};
  Polyline ground{{{feature.at_m, 0}}};
  ground.bend(0, feature.slope, bend_m);
  ground.to(ground.last().at + feature.span_m, ground.last().value + feature.slope * feature.span_m);
  ground.bend(feature.slope, 0, bend_m);
  site.relief.add(ground, across(feature));
}

void build_hill(Site& site, const Feature& feature) {
  const double bend_m{rounding_m(site)};
  const double straight_m{std::max(feature.span_m - 2 * bend_m, 0.1)};
  Polyline ground{{{feature.at_m, 0}}};
  ground.bend(0, feature.slope, bend_m);
  ground.to(ground.last().at + straight_m, ground.last().value + feature.slope * straight_m);
  ground.bend(feature.slope, -feature.slope, 2 * bend_m);
  ground.to(ground.last().at + straight_m, ground.last().value - feature.slope * straight_m);
  ground.bend(-feature.slope, 0, bend_m);
  site.relief.add(ground, across(feature));
}

void build_valley(Site& site, const Feature& feature) {
  Feature mirrored{feature};
  mirrored.slope = -feature.slope;
  build_hill(site, mirrored);
}

void build_bank(Site& site, const Feature& feature) {
  constexpr double half_width_m{12};
  const double end_m{feature.at_m + feature.span_m};
  const double rise_m{feature.slope * half_width_m};
  site.relief.add({{{feature.at_m, 0}, {end_m, 1}}}, {{{-half_width_m, -rise_m}, {half_width_m, rise_m}}});
}

void build_crown(Site& site, const Feature& feature) {
  constexpr double half_width_m{12};
  const double fall_m{-feature.slope * half_width_m};
  site.relief.add(everywhere(), {{{-half_width_m, fall_m}, {0, 0}, {half_width_m, fall_m}}});
}

void build_rolling(Site& site, const Feature& feature) {
  constexpr int waves{12};
  Polyline ground{{{feature.at_m, 0}}};
  for (int i{0}; i < waves; ++i) {
    ground.wave(feature.rise_m, feature.span_m / 2);
    ground.wave(-feature.rise_m, feature.span_m / 2);
  }
  site.relief.add(ground, across(feature));
}

void build_hump(Site& site, const Feature& feature) {
  Polyline ground{{{feature.at_m, 0}}};
  ground.wave(feature.rise_m, feature.span_m / 2).wave(-feature.rise_m, feature.span_m / 2);
  site.relief.add(ground, across(feature));
}

void build_kerb(Site& site, const Feature& feature) {
  add_step(site, feature, feature.rise_m);
}

void build_edge(Site& site, const Feature& feature) {
  add_step(site, feature, -std::abs(feature.rise_m));
}

void build_stairs(Site& site, const Feature& feature) {
  const double rise_m{feature.rise_m};
  Polyline ground{{{feature.at_m, 0}}};
  for (int i{0}; i < feature.steps; ++i) {
    if (i > 0) ground.to(ground.last().at + feature.span_m, ground.last().value);
    ground.to(ground.last().at, ground.last().value + rise_m);
  }
  if (feature.length_m < 100)
    ground.to(feature.at_m + feature.length_m, ground.last().value).to(feature.at_m + feature.length_m, 0);
  site.relief.add(ground, across(feature));
}

void build_ditch(Site& site, const Feature& feature) {
  Feature ditch{feature};
  ditch.length_m = feature.span_m;
  add_step(site, ditch, -std::abs(feature.rise_m));
}

void build_steep(Site& site, const Feature& feature) {
  const double end_m{feature.at_m + feature.span_m};
  const double rise_m{feature.slope * feature.span_m};
  Polyline ground{{{feature.at_m, 0}, {end_m, rise_m}}};
  if (feature.length_m < 100) ground.to(feature.at_m + feature.length_m, rise_m).to(feature.at_m + feature.length_m, 0);
  site.relief.add(ground, across(feature));
}

void build_steps(Site& site, const Feature& feature) {
  constexpr double gap{0.25};  // so that no step leads up to the next
  const double stripe_m{site.is_robot ? 0.4 : 1.2};
  for (int i{0}; i < feature.steps; ++i) {
    Feature lane{feature};
    lane.right_m = (i - feature.steps / 2.0) * stripe_m;
    lane.left_m = lane.right_m + (1 - gap) * stripe_m;
    add_step(site, lane, feature.rise_m * (i + 1) / feature.steps);
  }
}

void build_grass(Site& site, const Feature& feature) {
  const double pitch_m{site.is_robot ? 0.05 : 0.15};
  const double left_m{std::min(feature.left_m, site.is_robot ? 1.0 : 3.0)};
  const double right_m{std::max(feature.right_m, site.is_robot ? -1.0 : -3.0)};
  Polyline along{{{feature.at_m, 0}}};
  for (double x{pitch_m}; x < feature.span_m; x += pitch_m) along.to(feature.at_m + x, site.random.between(0, 1));
  along.to(feature.at_m + feature.span_m, 0);
  Polyline bumps{{{right_m, 0}}};
  for (double y{right_m + pitch_m}; y < left_m; y += pitch_m) bumps.to(y, feature.rise_m * site.random.between(0, 1));
  bumps.to(left_m, 0);
  site.relief.add(along, bumps);
  site.world.areas.push_back(
      {{feature.at_m, right_m}, {feature.at_m + feature.span_m, left_m}, {Pattern::plain, 85, 22, 0.3}});
}

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
