// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"
#include "stereogrid/truth.hpp"
#include "world/height_field.hpp"
#include "world/numbers.hpp"
#include "world/shapes.hpp"

namespace stereogrid::scenes {

enum class Pattern { plain, bricks, windows, planks, slabs, car_windows, lettering };

/// Appearance of a surface: a mean grey level, noise of every size around it, and a pattern.
struct Material {
  Pattern pattern{Pattern::plain};
  double grey{120};
  double contrast{15};  ///< about the standard deviation where six octaves are visible
  double coarsest_m{0.8};
};

/// A place on a surface in metres along two directions, and how much of it a pixel covers in each.
struct SurfacePoint {
  double a{0};
  double b{0};
  double footprint_a{0};
  double footprint_b{0};
};

/// Grey level of a surface before light falls on it. Detail finer than a pixel is faded out, so that both cameras (and
/// the next frame) see the same signal. `half_height` is half the size of the solid along b.
[[nodiscard]] double surface_grey(const Material& material, std::uint32_t seed, const SurfacePoint& point,
                                  double half_height);

/// Paint on the road, along and to the left of its centre line. A period of 0 is a solid stroke.
struct Paint {
  double along_min_m{-1e4};
  double along_max_m{1e4};
  double left_min_m{0};
  double left_max_m{0};
  double dash_m{0};
  double period_m{0};
};

/// The plane z = 0 with the markings of a road whose centre line is an arc that starts along +x at (0, centre_left_m).
struct Road {
  double centre_left_m{0};
  double curvature_per_m{0};
  std::vector<Paint> paint;
};

/// Grey level of the road at a world point. `step_u`, `step_v`: how far the point moves per pixel.
[[nodiscard]] double road_grey(const Road& road, std::uint32_t seed, Point2 point, Vector3 step_u, Vector3 step_v);

/// Grey level of open ground: the road's texture with coarser octaves, which remain visible far away.
[[nodiscard]] double ground_grey(std::uint32_t seed, const SurfacePoint& point);

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
