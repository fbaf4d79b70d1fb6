// SPDX-License-Identifier: Apache-2.0
#include "world/world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace stereogrid::scenes {

Pose2 along_arc(const Pose2& start, double curvature_per_m, double distance_m, double left_m) {
  const Direction heading{direction_of(start.yaw_rad)};
  double ahead{distance_m};
  double left{left_m};
  double turn{0};
  if (curvature_per_m != 0) {
    turn = curvature_per_m * distance_m;
    const Direction turned{direction_of(turn)};
    ahead = turned.sine * (1 / curvature_per_m - left_m);
    left = 1 / curvature_per_m - turned.cosine * (1 / curvature_per_m - left_m);
  }
  return {start.x_m + heading.cosine * ahead - heading.sine * left,
          start.y_m + heading.sine * ahead + heading.cosine * left, std::remainder(start.yaw_rad + turn, 2 * pi)};
}

Pose2 Motion::pose_at(double time_s) const {
  const double moving_s{std::clamp(time_s, begin_s, end_s) - begin_s};
  return along_arc(start, curvature_per_m, speed_mps * moving_s);
}

double Motion::speed_at(double time_s) const {
  return time_s >= begin_s && time_s < end_s ? speed_mps : 0.0;
}

void World::add(Body body, double surface_height_m) {
  for (Part& part : body.parts) part.centre.z += surface_height_m;
  if (body.label == TruthLabel::obstacle) body.id = ++last_id_;
  bodies.push_back(std::move(body));
}

void World::add_on_ground(Body body, double raised_m) {
  body.ground_m = ground.height_at(body.motion.start.x_m, body.motion.start.y_m);
  const double surface_m{body.ground_m + raised_m};
  add(std::move(body), surface_m);
}

std::vector<PlacedPart> World::at(double time_s) const {
  std::vector<PlacedPart> placed;
  for (std::size_t b{0}; b < bodies.size(); ++b) {
    const Body& body{bodies[b]};
    const Pose2 pose{body.motion.pose_at(time_s)};
    const Direction heading{direction_of(pose.yaw_rad)};
    for (std::size_t p{0}; p < body.parts.size(); ++p) {
      const Part& part{body.parts[p]};
      const Vector3 centre{pose.x_m + heading.cosine * part.centre.x - heading.sine * part.centre.y,
                           pose.y_m + heading.sine * part.centre.x + heading.cosine * part.centre.y, part.centre.z};
      const auto texture_seed = static_cast<std::uint32_t>(scramble(seed ^ scramble(b * 64 + p)));
      placed.push_back({&part, &body, centre, direction_of(pose.yaw_rad + part.yaw_rad), texture_seed});
    }
  }
  return placed;
}

namespace {

/// A box given by its size and the middle of its bottom.
Part box(Vector3 bottom, Vector3 size, const Material& material) {
  const Vector3 half{0.5 * size};
  return {{Shape::box, half}, {bottom.x, bottom.y, bottom.z + half.z}, 0, material};
}

Part cylinder(Vector3 bottom, double radius, double height, const Material& material) {
  return {{Shape::cylinder, {radius, radius, height / 2}}, {bottom.x, bottom.y, bottom.z + height / 2}, 0, material};
}

Part ellipsoid(Vector3 centre, Vector3 half, const Material& material) {
  return {{Shape::ellipsoid, half}, centre, 0, material};
}

Body at_rest(std::string kind, const Pose2& pose, std::vector<Part> parts) {
  Body body;
  body.kind = std::move(kind);
  body.motion.start = pose;
  body.parts = std::move(parts);
  return body;
}

void add_wheels(std::vector<Part>& parts, double axle_x, double side_y) {
  for (const double x : {-axle_x, axle_x}) {
    for (const double y : {-side_y, side_y}) {
      parts.push_back({{Shape::wheel, {0.31, 0.11, 0.31}}, {x, y, 0.31}, 0, {Pattern::plain, 48, 12, 0.2}});
    }
  }
}

}  // namespace

Body make_car(const Pose2& pose, Random& random) {
  const Material paint{Pattern::plain, random.between(60, 190), random.between(7, 11), 0.4};
  const Material cabin{Pattern::car_windows, paint.grey, 8, 0.4};
  const double length{random.between(4.0, 4.5)};
  const double height{random.between(1.42, 1.55)};
  std::vector<Part> parts{box({0, 0, 0.22}, {length, 1.76, 0.66}, paint),
                          box({-0.25, 0, 0.88}, {length * 0.55, 1.56, height - 0.88}, cabin)};
  add_wheels(parts, length * 0.31, 0.8);
  return at_rest("car", pose, std::move(parts));
}

Body make_van(const Pose2& pose, Random& random) {
  const Material side{Pattern::lettering, random.between(165, 185), 3.5, 0.8};
  const Material front{Pattern::car_windows, side.grey, 8, 0.4};
  std::vector<Part> parts{box({-0.55, 0, 0.3}, {4.1, 1.95, 1.95}, side), box({2.0, 0, 0.3}, {1.0, 1.9, 0.75}, side),
                          box({1.85, 0, 1.05}, {0.7, 1.8, 0.8}, front)};
  add_wheels(parts, 1.5, 0.9);
  return at_rest("van", pose, std::move(parts));
}

Body make_person(const Pose2& pose, Random& random) {
  const Material trousers{Pattern::plain, random.between(45, 90), 11, 0.1};
  const Material jacket{Pattern::plain, random.between(90, 180), 20, 0.2};
  const Material skin{Pattern::plain, 150, 10, 0.1};
  return at_rest("pedestrian", pose,
                 {cylinder({0.12, 0.1, 0}, 0.085, 0.85, trousers),
                  cylinder({-0.12, -0.1, 0}, 0.085, 0.85, trousers),
                  {{Shape::cylinder, {0.15, 0.21, 0.34}}, {0, 0, 1.14}, 0, jacket},
                  cylinder({0.05, 0.26, 0.72}, 0.055, 0.72, jacket),
                  cylinder({-0.05, -0.26, 0.72}, 0.055, 0.72, jacket),
                  ellipsoid({0.02, 0, 1.61}, {0.11, 0.09, 0.14}, skin)});
}

Body make_house(const Pose2& pose, double length_m, double width_m, double height_m, Random& random) {
  const Material walls{Pattern::windows, random.between(120, 195), random.between(10, 16), 1.6};
  return at_rest("building", pose, {box({}, {length_m, width_m, height_m}, walls)});
}

Body make_wall(const Pose2& pose, double length_m, double height_m, Random& random) {
  const Material stones{Pattern::bricks, random.between(110, 135), 16, 0.8};
  return at_rest("wall", pose, {box({}, {length_m, 0.4, height_m}, stones)});
}

Body make_crate(const Pose2& pose, Vector3 size_m, Random& random) {
  const Material wood{Pattern::planks, random.between(130, 160), 16, 0.4};
  return at_rest("box", pose, {box({}, size_m, wood)});
}

Body make_pole(const Pose2& pose, double height_m, Random& random) {
  const Material metal{Pattern::plain, random.between(70, 150), 12, 0.4};
  return at_rest("pole", pose, {cylinder({}, 0.08, height_m, metal)});
}

Body make_tree(const Pose2& pose, Random& random) {
  const Material bark{Pattern::plain, 80, 20, 0.2};
  const Material leaves{Pattern::plain, random.between(75, 100), 30, 0.3};
  const double crown{random.between(1.1, 1.5)};
  return at_rest("tree", pose,
                 {cylinder({}, 0.16, 2.8, bark), ellipsoid({0, 0, 2.3 + crown}, {crown, crown, crown}, leaves),
                  ellipsoid({0.5, 0.4, 2.6 + 1.5 * crown}, {0.8 * crown, 0.9 * crown, 0.8 * crown}, leaves),
                  ellipsoid({-0.4, -0.5, 3.0 + crown}, {0.9 * crown, 0.8 * crown, 0.7 * crown}, leaves)});
}

Body make_pavement(const Pose2& pose, double length_m, double width_m) {
  Body slab{
      at_rest("pavement", pose, {box({}, {length_m, width_m, pavement_height_m}, {Pattern::slabs, 140, 12, 0.8})})};
  slab.label = TruthLabel::low;
  return slab;
}

}  // namespace stereogrid::scenes
