// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/truth.hpp"
#include "world/height_field.hpp"
#include "world/materials.hpp"
#include "world/numbers.hpp"
#include "world/shapes.hpp"

namespace stereogrid::scenes {

/// A convex piece of a body, in the body's frame (x forward, z up from the ground).
struct Part {
  Solid solid;
  Vector3 centre;
  double yaw_rad{0};
  Material material;
};

/// Constant speed along an arc between two instants, at rest before and after. Curvature 0: straight.
struct Motion {
  Pose2 start;
  double speed_mps{0};
  double curvature_per_m{0};  ///< positive: to the left
  double begin_s{0};
  double end_s{1e9};

  [[nodiscard]] Pose2 pose_at(double time_s) const;
  /// Speed at that instant; the heading of pose_at is its direction.
  [[nodiscard]] double speed_at(double time_s) const;
};

/// The pose `distance_m` along an arc and `left_m` to the left of it.
[[nodiscard]] Pose2 along_arc(const Pose2& start, double curvature_per_m, double distance_m, double left_m = 0);

/// A rigid thing.
struct Body {
  std::string kind;
  TruthLabel label{TruthLabel::obstacle};
  Motion motion;
  std::vector<Part> parts;
  double ground_m{0};   ///< height of the ground that its heights are measured from
  std::uint16_t id{0};  ///< given by World::add; 0 for low things, which have no identity
};

/// A part where it stands at one instant, in the world frame.
struct PlacedPart {
  const Part* part{nullptr};
  const Body* body{nullptr};
  Vector3 centre;
  Direction heading;
  std::uint32_t texture_seed{0};
};

/// A rectangle of the ground with another surface.
struct GroundArea {
  Point2 low;
  Point2 high;
  Material material;
  bool mirrors_sky{false};
};

/// Ground, bodies, the ego vehicle's motion.
struct World {
  std::uint64_t seed{1};
  Road road;  ///< texture of the ground
  HeightField ground;
  std::vector<GroundArea> areas;  ///< on a height field that is not flat
  Motion ego;
  Wheels wheels;
  std::vector<Body> bodies;
  std::vector<TruthZone> zones;

  /// Puts a body on a surface of that height (0: the road).
  void add(Body body, double surface_height_m = 0);
  /// Puts a body on the ground below its origin, `raised_m` above it.
  void add_on_ground(Body body, double raised_m = 0);
  /// The parts at one instant. They point into this world.
  [[nodiscard]] std::vector<PlacedPart> at(double time_s) const;

 private:
  std::uint16_t last_id_{0};
};

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
