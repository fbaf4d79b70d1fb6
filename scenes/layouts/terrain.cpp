// SPDX-License-Identifier: Apache-2.0
#include "layouts/terrain.hpp"

#include <algorithm>
#include <utility>

#include "layouts/layouts.hpp"

namespace stereogrid::scenes {
namespace {

constexpr double far_away_m{1e3};

double tangent_of(double angle_deg) {
  const Direction direction{direction_of(angle_deg * pi / 180)};
  return direction.sine / direction.cosine;
}

template <class Number>
Number either(Number wanted, Number otherwise) {
  return wanted != 0 ? wanted : otherwise;
}

/// A random layout: any kind, most of its sizes between 0.6 and 1.4 times the usual ones.
TerrainKind::Sizes drawn(const TerrainKind& kind, bool is_robot, Random& random) {
  TerrainKind::Sizes sizes{is_robot ? kind.robot : kind.car};
  sizes.at_m *= random.between(0.7, 1.5);
  sizes.rise_m *= random.between(0.7, 1.5);
  sizes.slope_deg *= random.between(0.4, 1.4);
  sizes.span_m *= random.between(0.7, 1.5);
  if (random.between(0, 1) < 0.4 && (kind.name == "kerb" || kind.name == "stairs")) sizes.rise_m *= -1;
  if (random.between(0, 1) < 0.4 && (kind.name == "ramp" || kind.name == "steep")) sizes.slope_deg *= -1;
  return sizes;
}

}  // namespace

Site::Site(const SceneOptions& options) : is_robot{options.camera == "robot"}, random{options.seed} {
  world.seed = options.seed;
  world.road.centre_left_m = far_away_m;
  if (is_robot) world.wheels = {0.1, 0.2, 0.15};
  world.ego.start.yaw_rad = options.skew_deg * pi / 180;
  world.ego.speed_mps = options.speed_mps;
}

World Site::finished() {
  world.ground = relief.field();
  for (Waiting& waiting : waiting_) world.add_on_ground(std::move(waiting.body), waiting.raised_m);
  return std::move(world);
}

const std::vector<TerrainKind>& all_terrain_kinds() {
  // at, rise, slope, span, steps
  static const std::vector<TerrainKind> all{{"bank", build_bank, {3, 0, 10, 3, 0}, {1, 0, 10, 1, 0}},
                                            {"barrier", build_barrier, {5, 0.8, 0, 0, 0}, {1.5, 0.3, 0, 0, 0}},
                                            {"box", build_box, {6, 0.5, 0, 0.6, 0}, {1.5, 0.15, 0, 0.2, 0}},
                                            {"branch", build_branch, {5, 1.1, 0, 0, 0}, {1.5, 0.35, 0, 0, 0}},
                                            {"bridge", build_bridge, {5, 2.5, 0, 3, 0}, {1.5, 0.9, 0, 1, 0}},
                                            {"crown", build_crown, {0, 0, 4, 0, 0}, {0, 0, 4, 0, 0}},
                                            {"ditch", build_ditch, {5, -0.8, 0, 0.8, 0}, {1.5, -0.3, 0, 0.3, 0}},
                                            {"edge", build_edge, {5, -0.9, 0, 0, 0}, {1.5, -0.3, 0, 0, 0}},
                                            {"flat", build_flat, {0, 0, 0, 0, 0}, {0, 0, 0, 0, 0}},
                                            {"grass", build_grass, {4, 0.04, 0, 4, 0}, {1, 0.01, 0, 1.5, 0}},
                                            {"hill", build_hill, {4, 0, 6, 4, 0}, {1.2, 0, 6, 1.5, 0}},
                                            {"hump", build_hump, {5, 0.08, 0, 0.6, 0}, {1.5, 0.02, 0, 0.3, 0}},
                                            {"kerb", build_kerb, {5, 0.2, 0, 0, 0}, {1.5, 0.06, 0, 0, 0}},
                                            {"paint", build_paint, {5, 0, 0, 2, 0}, {1.2, 0, 0, 0.6, 0}},
                                            {"post", build_post, {5, 1, 0, 0, 0}, {1.5, 0.4, 0, 0, 0}},
                                            {"puddle", build_puddle, {5, 0, 0, 2, 0}, {1.2, 0, 0, 0.6, 0}},
                                            {"ramp", build_ramp, {4, 0, 8, 12, 0}, {1.2, 0, 8, 4, 0}},
                                            {"rolling", build_rolling, {2, 0.15, 0, 8, 0}, {0.8, 0.04, 0, 2.5, 0}},
                                            {"rubble", build_rubble, {4, 0.15, 0, 5, 60}, {1, 0.08, 0, 1.5, 40}},
                                            {"stairs", build_stairs, {5, 0.17, 0, 0.3, 6}, {1.5, 0.12, 0, 0.25, 6}},
                                            {"steep", build_steep, {5, 0, 45, 1.5, 0}, {1.5, 0, 45, 0.6, 0}},
                                            {"steps", build_steps, {5, 0.3, 0, 0, 6}, {1.5, 0.12, 0, 0, 6}},
                                            {"table", build_desk, {5, 0.75, 0, 0.8, 0}, {1.5, 0.3, 0, 0.4, 0}},
                                            {"valley", build_valley, {4, 0, 6, 5, 0}, {1.2, 0, 6, 1.5, 0}}};
  return all;
}

const TerrainKind& terrain_kind(std::string_view name) {
  return *std::ranges::find(all_terrain_kinds(), name, &TerrainKind::name);
}

std::vector<std::string> terrain_kinds() {
  std::vector<std::string> names;
  for (const TerrainKind& kind : all_terrain_kinds()) names.emplace_back(kind.name);
  return names;
}

Feature feature_of(const TerrainKind& kind, const TerrainKind::Sizes& wanted, bool is_robot) {
  const TerrainKind::Sizes& usual{is_robot ? kind.robot : kind.car};
  Feature feature;
  feature.at_m = either(wanted.at_m, usual.at_m);
  feature.rise_m = either(wanted.rise_m, usual.rise_m);
  feature.slope = tangent_of(either(wanted.slope_deg, usual.slope_deg));
  feature.span_m = either(wanted.span_m, usual.span_m);
  feature.steps = either(wanted.steps, usual.steps);
  return feature;
}

World build_terrain(const SceneOptions& options) {
  Site site{options};
  TerrainKind::Sizes wanted{options.edge_m, options.rise_m, options.slope_deg, options.span_m, options.steps};
  const auto& kinds{all_terrain_kinds()};
  const bool is_random{options.kind == "random"};
  const auto place = static_cast<std::size_t>(site.random.between(0, static_cast<double>(kinds.size())));
  const TerrainKind& kind{is_random ? kinds[place] : terrain_kind(options.kind)};
  if (is_random) wanted = drawn(kind, site.is_robot, site.random);
  Feature feature{feature_of(kind, wanted, site.is_robot)};
  const double travel_m{options.speed_mps * (options.frames - 1) / options.rate_hz};
  feature.at_m = (feature.at_m + travel_m) * direction_of(site.world.ego.start.yaw_rad).cosine;
  kind.build(site, feature);
  return site.finished();
}

}  // namespace stereogrid::scenes
