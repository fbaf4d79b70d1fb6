// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string_view>

#include "layouts/layouts.hpp"
#include "layouts/terrain.hpp"

namespace stereogrid::scenes {
namespace {

enum class Lies { across, left, right };

/// A thing of the course: sizes are those of its kind times `scale`.
struct Item {
  std::string_view kind;
  Lies lies;
  double rise{1};
  double span{1};
  double slope{1};
};

constexpr double course_m{170};  // as layouts.cpp says

// 24 hazards, at the sides of a lane that is free, and 12 harmless things across it or beside it.
constexpr std::array<Item, 36> items{{
    {"box", Lies::left},
    {"kerb", Lies::right},
    {"paint", Lies::across},
    {"ditch", Lies::left},
    {"edge", Lies::right},
    {"hump", Lies::across},
    {"post", Lies::right},
    {"stairs", Lies::left, -1},
    {"hill", Lies::across},
    {"rubble", Lies::left},
    {"barrier", Lies::right},
    {"puddle", Lies::across},
    {"edge", Lies::left, 0.4},
    {"ditch", Lies::right, 1, 0.5},
    {"grass", Lies::left},
    {"steep", Lies::left, 1, 1},
    {"table", Lies::right},
    {"valley", Lies::across},
    {"stairs", Lies::right},
    {"ditch", Lies::left, 1, 1.6},
    {"paint", Lies::right},
    {"branch", Lies::left},
    {"edge", Lies::right, 3.9},
    {"bridge", Lies::across},
    {"box", Lies::right, 0.4},
    {"kerb", Lies::left, 1.25},
    {"hump", Lies::across, 0.6},
    {"steep", Lies::right, 1, 1, -1},
    {"post", Lies::left, 0.6},
    {"grass", Lies::right},
    {"ditch", Lies::right, 1, 0.8},
    {"rubble", Lies::right, 1.2},
    {"puddle", Lies::left},
    {"box", Lies::left, 1.6},
    {"edge", Lies::left, 0.6},
    {"rolling", Lies::across, 0.5, 0.5},
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
