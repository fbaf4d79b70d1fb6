// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "world.hpp"

namespace stereogrid::scenes {

/// A scene: what it is called, how many frames it was made for, and what is in it. The seed varies textures and
/// details; where the things with a part to play are does not depend on it.
struct Layout {
  std::string_view name;
  int frames{0};
  World (*build)(std::uint64_t seed, double duration_s){nullptr};
};

/// All of them, in alphabetical order.
[[nodiscard]] const std::vector<Layout>& layouts();

/// Car still. Boxes 0.1, 0.15, 0.2, 0.3 and 0.5 m high from right to left, 8 and 14 m ahead; a kerb on the right.
[[nodiscard]] World build_boxes(std::uint64_t seed, double duration_s);
/// Car still. A walker crosses from right to left, a car behind him from left to right.
[[nodiscard]] World build_crossing(std::uint64_t seed, double duration_s);
/// Nothing but the road, at 5 m/s.
[[nodiscard]] World build_empty(std::uint64_t seed, double duration_s);
/// Car still. A person whose lower half is hidden by a crate.
[[nodiscard]] World build_occlusion(std::uint64_t seed, double duration_s);
/// 8 m/s on a slight curve between parked cars; an oncoming car, people stepping out.
[[nodiscard]] World build_street(std::uint64_t seed, double duration_s);
/// 5 m/s in an alley, up to 5 m behind a van whose back hides most of the road; wall left, pavement right.
[[nodiscard]] World build_van(std::uint64_t seed, double duration_s);
/// Car still before a wall that hides everything behind it.
[[nodiscard]] World build_wall(std::uint64_t seed, double duration_s);

/// Lane markings of a two-lane road whose right lane's middle is the line y = 0.
[[nodiscard]] Road two_lanes(double lane_width_m, double curvature_per_m);

}  // namespace stereogrid::scenes
