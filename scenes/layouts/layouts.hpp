// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "stereogrid/scenes/scene.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

/// Scene: name, default number of frames, and content. The seed varies textures and details, but not the positions of
/// the main objects.
struct Layout {
  std::string_view name;
  int frames{0};
  World (*build)(const SceneOptions& options){nullptr};
  double length_m{0};  ///< as many frames as this takes; 0: `frames`
};

/// All of them, in alphabetical order.
[[nodiscard]] const std::vector<Layout>& layouts();

/// Car still between walls. A walker goes around it on a circle of 4 m, for cameras=4.
[[nodiscard]] World build_around(const SceneOptions& options);
/// Car still. Boxes 0.1, 0.15, 0.2, 0.3 and 0.5 m high from right to left, 8 and 14 m ahead; a kerb on the right.
[[nodiscard]] World build_boxes(const SceneOptions& options);
/// For a robot that finds its own way: a box, a walker, a ramp and, beside the goal, stairs down between walls.
[[nodiscard]] World build_corridor(const SceneOptions& options);
/// Car still. A walker crosses from right to left, a car behind him from left to right.
[[nodiscard]] World build_crossing(const SceneOptions& options);
/// Nothing but the road, at 5 m/s.
[[nodiscard]] World build_empty(const SceneOptions& options);
/// Car still. A person whose lower half is hidden by a crate.
[[nodiscard]] World build_occlusion(const SceneOptions& options);
/// 170 m with 24 hazards beside the vehicle's path and 12 things that are none.
[[nodiscard]] World build_course(const SceneOptions& options);
/// Drives 4 m at 2 m/s, then stands `edge_m` (2.5) before a pallet with a load, `rise_m` (0.5) high.
[[nodiscard]] World build_pallet(const SceneOptions& options);
/// The same before the whole width of the ground rises or falls by `rise_m`, in `steps` slopes of `incline_deg` (90:
/// steps of stairs, a platform's edge).
[[nodiscard]] World build_step(const SceneOptions& options);
/// 8 m/s on a slight curve between parked cars; an oncoming car, people stepping out.
[[nodiscard]] World build_street(const SceneOptions& options);
/// Drives as build_pallet before a table, 2.4 m wide and `rise_m` high.
[[nodiscard]] World build_table(const SceneOptions& options);
/// Uneven ground of one kind.
[[nodiscard]] World build_terrain(const SceneOptions& options);
/// 5 m/s in an alley, up to 5 m behind a van whose back hides most of the road; wall left, pavement right.
[[nodiscard]] World build_van(const SceneOptions& options);
/// Car still before a wall that hides everything behind it.
[[nodiscard]] World build_wall(const SceneOptions& options);

/// Lane markings of a two-lane road whose right lane's middle is the line y = 0.
[[nodiscard]] Road two_lanes(double lane_width_m, double curvature_per_m);

/// Fills in the defaults. Throws InputError for an unknown scene or a value out of range.
[[nodiscard]] SceneOptions completed(SceneOptions options);

[[nodiscard]] World build_world(const SceneOptions& options);

}  // namespace stereogrid::scenes
