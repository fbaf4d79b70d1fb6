// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "layouts/layouts.hpp"

namespace stereogrid::scenes {

const std::vector<Layout>& layouts() {
  static const std::vector<Layout> all{
      {"boxes", 10, build_boxes},       {"corridor", 600, build_corridor}, {"course", 100, build_course, 170},
      {"crossing", 40, build_crossing}, {"empty", 20, build_empty},        {"occlusion", 10, build_occlusion},
      {"pallet", 50, build_pallet},     {"step", 50, build_step},          {"street", 60, build_street},
      {"table", 50, build_table},       {"terrain", 3, build_terrain},     {"van", 30, build_van},
      {"wall", 5, build_wall}};
  return all;
}

Road two_lanes(double lane_width_m, double curvature_per_m) {
  constexpr double half_line_m{0.07};
  Road road;
  road.centre_left_m = lane_width_m / 2;
  road.curvature_per_m = curvature_per_m;
  road.paint.push_back({-1e4, 1e4, -half_line_m, half_line_m, 3, 7.5});
  for (const double edge : {-lane_width_m, lane_width_m}) {
    road.paint.push_back({-1e4, 1e4, edge - half_line_m, edge + half_line_m, 0, 0});
  }
  return road;
}

}  // namespace stereogrid::scenes
