// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "stereogrid/scenes/scene.hpp"
#include "world/height_field.hpp"
#include "world/numbers.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Something to put on the ground, in the world: where it begins along x, how wide it is, and its sizes.
struct Feature {
  double at_m{0};
  double rise_m{0};
  double slope{0};  ///< tangent
  double span_m{0};
  int steps{0};
  double right_m{-400};
  double left_m{400};
  double length_m{1e3};  ///< length of raised or lowered ground

  [[nodiscard]] double middle_m() const { return (right_m + left_m) / 2; }
  [[nodiscard]] double width_m() const { return left_m - right_m; }
};

/// A world in the making: bodies wait until the ground is complete.
class Site {
 public:
  explicit Site(const SceneOptions& options);

  void put(Body body, double raised_m = 0) { waiting_.push_back({std::move(body), raised_m}); }
  [[nodiscard]] World finished();

  bool is_robot;
  Random random;
  Relief relief;
  World world;

 private:
  struct Waiting {
    Body body;
    double raised_m;
  };
  std::vector<Waiting> waiting_;
};

/// Builder of a kind of terrain, and its default sizes for a car and a robot.
struct TerrainKind {
  struct Sizes {
    double at_m;
    double rise_m;
    double slope_deg;
    double span_m;
    int steps;
  };
  std::string_view name;
  void (*build)(Site& site, const Feature& feature);
  Sizes car;
  Sizes robot;
};

/// In alphabetical order.
[[nodiscard]] const std::vector<TerrainKind>& all_terrain_kinds();
[[nodiscard]] const TerrainKind& terrain_kind(std::string_view name);
/// Sizes that are 0 in `wanted` are the kind's.
[[nodiscard]] Feature feature_of(const TerrainKind& kind, const TerrainKind::Sizes& wanted, bool is_robot);

// Ground.
void build_flat(Site& site, const Feature& feature);
void build_ramp(Site& site, const Feature& feature);
void build_valley(Site& site, const Feature& feature);
void build_hill(Site& site, const Feature& feature);
void build_bank(Site& site, const Feature& feature);
void build_crown(Site& site, const Feature& feature);
void build_rolling(Site& site, const Feature& feature);
void build_hump(Site& site, const Feature& feature);
void build_kerb(Site& site, const Feature& feature);
void build_edge(Site& site, const Feature& feature);
void build_stairs(Site& site, const Feature& feature);
void build_ditch(Site& site, const Feature& feature);
void build_steep(Site& site, const Feature& feature);
void build_steps(Site& site, const Feature& feature);
void build_grass(Site& site, const Feature& feature);

// Surfaces and bodies.
void build_paint(Site& site, const Feature& feature);
void build_puddle(Site& site, const Feature& feature);
void build_rubble(Site& site, const Feature& feature);
void build_box(Site& site, const Feature& feature);
void build_post(Site& site, const Feature& feature);
void build_barrier(Site& site, const Feature& feature);
void build_branch(Site& site, const Feature& feature);
void build_desk(Site& site, const Feature& feature);
void build_bridge(Site& site, const Feature& feature);

}  // namespace stereogrid::scenes
