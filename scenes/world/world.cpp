// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "world/numbers.hpp"

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

}  // namespace stereogrid::scenes
