// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "world/random.hpp"
#include "world/world.hpp"

namespace stereogrid::scenes {

// Street furniture. Bodies stand on z = 0 at their pose, facing along it, and rest; give the result another motion to
// make it move. The random numbers vary colours and details, not where a body is.

[[nodiscard]] Body make_car(const Pose2& pose, Random& random);
/// A delivery van whose sides have hardly any texture.
[[nodiscard]] Body make_van(const Pose2& pose, Random& random);
/// 1.75 m tall.
[[nodiscard]] Body make_person(const Pose2& pose, Random& random);
/// `length_m` along its pose, `width_m` across; the pose is its middle.
[[nodiscard]] Body make_house(const Pose2& pose, double length_m, double width_m, double height_m, Random& random);
[[nodiscard]] Body make_wall(const Pose2& pose, double length_m, double height_m, Random& random);
[[nodiscard]] Body make_crate(const Pose2& pose, Vector3 size_m, Random& random);
[[nodiscard]] Body make_pole(const Pose2& pose, double height_m, Random& random);
/// Trunk below 2.2 m, crown above.
[[nodiscard]] Body make_tree(const Pose2& pose, Random& random);
/// A low slab, 0.12 m high.
[[nodiscard]] Body make_pavement(const Pose2& pose, double length_m, double width_m);
constexpr double pavement_height_m{0.12};

}  // namespace stereogrid::scenes
