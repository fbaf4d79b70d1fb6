// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "layouts/terrain.hpp"

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

}  // namespace stereogrid::scenes
