// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/obstacle.hpp"

namespace stereogrid::io {

/// A field of an obstacle in frames.jsonl.
struct ObstacleField {
  const char* name;
  bool is_required{true};  ///< false: missing in runs of older versions, which leave the default
  double largest{1e6};     ///< largest magnitude of a number that is read
  double steps{1000};      ///< compact lines round numbers to 1/steps
};

/// Calls visit(ObstacleField, member) for every field, in the order of frames.jsonl (docs/format.md).
template <class AnyObstacle, class Visit>
void visit_fields(AnyObstacle& o, Visit&& visit) {
  constexpr double longest_s{1e10};  // between any two stamps
  visit(ObstacleField{"id"}, o.id);
  visit(ObstacleField{"x_m"}, o.x_m);
  visit(ObstacleField{"y_m"}, o.y_m);
  visit(ObstacleField{"vx_mps"}, o.vx_mps);
  visit(ObstacleField{"vy_mps"}, o.vy_mps);
  visit(ObstacleField{"length_m"}, o.length_m);
  visit(ObstacleField{"width_m"}, o.width_m);
  visit(ObstacleField{.name = "yaw_rad", .steps = 10'000}, o.yaw_rad);
  visit(ObstacleField{.name = "age_s", .largest = longest_s}, o.age_s);
  visit(ObstacleField{"occupancy"}, o.occupancy);
  visit(ObstacleField{"confirmed"}, o.confirmed);
  visit(ObstacleField{"moving", false}, o.moving);
  visit(ObstacleField{"coasting", false}, o.coasting);
  visit(ObstacleField{"unseen_s", false, longest_s}, o.unseen_s);
  visit(ObstacleField{.name = "position_covariance", .is_required = false}, o.position_covariance);
  visit(ObstacleField{.name = "velocity_covariance", .is_required = false}, o.velocity_covariance);
  visit(ObstacleField{"kind", false}, o.kind);
  visit(ObstacleField{"height_m", false}, o.height_m);
  visit(ObstacleField{"outline_m", false}, o.outline);
  visit(ObstacleField{"yaw_rate_radps", false}, o.yaw_rate_radps);
  visit(ObstacleField{"length_sigma_m", false}, o.length_sigma_m);
  visit(ObstacleField{"width_sigma_m", false}, o.width_sigma_m);
  visit(ObstacleField{"yaw_sigma_rad", false}, o.yaw_sigma_rad);
}

}  // namespace stereogrid::io
