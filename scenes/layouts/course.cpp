// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <string_view>

#include "layouts/layouts.hpp"
#include "layouts/terrain.hpp"

namespace stereogrid::scenes {
namespace {

enum class Lies { across, left, right };

/// A thing of the course: sizes are those of its kind times `scale`.
struct Item {
  bool is_hazard;
  std::string_view kind;
  Lies lies;
  double rise{1};
  double span{1};
  double slope{1};
};

constexpr double course_m{170};  // as layouts.cpp says

// 24 hazards, at the sides of a lane that is free, and 12 harmless things across it or beside it.
constexpr std::array<Item, 36> items{{
    {true, "box", Lies::left},
    {true, "kerb", Lies::right},
    {false, "paint", Lies::across},
    {true, "ditch", Lies::left},
    {true, "edge", Lies::right},
    {false, "hump", Lies::across},
    {true, "post", Lies::right},
    {true, "stairs", Lies::left, -1},
    {false, "hill", Lies::across},
    {true, "rubble", Lies::left, 1.6},
    {true, "barrier", Lies::right},
    {false, "puddle", Lies::across},
    {true, "edge", Lies::left, 0.4},
    {true, "ditch", Lies::right, 1, 0.5},
    {false, "grass", Lies::left},
    {true, "steep", Lies::left, 1, 1},
    {true, "table", Lies::right},
    {false, "valley", Lies::across},
    {true, "stairs", Lies::right},
    {true, "ditch", Lies::left, 1, 1.6},
    {false, "paint", Lies::right},
    {true, "branch", Lies::left},
    {true, "edge", Lies::right, 3.9},
    {false, "bridge", Lies::across},
    {true, "box", Lies::right, 0.4},
    {true, "kerb", Lies::left, 1.25},
    {false, "hump", Lies::across, 0.6},
    {true, "steep", Lies::right, 1, 1, -1},
    {true, "post", Lies::left, 0.6},
    {false, "grass", Lies::right},
    {true, "ditch", Lies::right, 1, 0.8},
    {true, "rubble", Lies::right, 2},
    {false, "puddle", Lies::left},
    {true, "box", Lies::left, 1.6},
    {true, "edge", Lies::left, 0.6},
    {false, "rolling", Lies::across, 0.5, 0.5},
}};

void put_item(Site& site, const Item& item, double at_m) {
  const TerrainKind& kind{terrain_kind(item.kind)};
  const TerrainKind::Sizes& usual{site.is_robot ? kind.robot : kind.car};
  Feature feature{feature_of(
      kind, {at_m, item.rise * usual.rise_m, item.slope * usual.slope_deg, item.span * usual.span_m, usual.steps},
      site.is_robot)};
  const double beside_m{site.is_robot ? 0.5 : 1.6};
  const double wide_m{site.is_robot ? 1.2 : 3.0};
  feature.length_m = site.is_robot ? 1.6 : 3.2;
  if (item.lies == Lies::left) {
    feature.right_m = beside_m;
    feature.left_m = beside_m + wide_m;
  } else if (item.lies == Lies::right) {
    feature.left_m = -beside_m;
    feature.right_m = -beside_m - wide_m;
  }
  kind.build(site, feature);
  const double around_m{site.is_robot ? 0.2 : 0.4};
  if (item.lies == Lies::across) {
    feature.right_m = -beside_m + around_m;
    feature.left_m = beside_m - around_m;
  }
  site.world.zones.push_back({std::string{item.kind},
                              item.is_hazard,
                              {at_m - around_m, feature.right_m - around_m},
                              {at_m + feature.length_m + around_m, feature.left_m + around_m}});
}

}  // namespace

World build_course(const SceneOptions& options) {
  constexpr double first_m{6};
  constexpr double spacing_m{(course_m - first_m) / items.size()};
  Site site{options};
  for (std::size_t i{0}; i < items.size(); ++i) put_item(site, items[i], first_m + spacing_m * static_cast<double>(i));
  return site.finished();
}

}  // namespace stereogrid::scenes
