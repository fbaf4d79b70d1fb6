// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "targets/pipeline_input.hpp"

#include <algorithm>
#include <cmath>

#include "support.hpp"

namespace stereogrid::fuzz {
namespace {

template <class Values, class Condition>
void require_all(const Values& values, const std::string& name, const char* what, Condition fine) {
  for (const auto value : values) {
    if (!fine(value)) throw Finding{name + " holds " + std::to_string(value) + ", which is not " + what};
  }
}

void check_probabilities(const Image<float>& image, const std::string& name) {
  require_all(image, name, "within 0 … 1", [](float p) { return p >= 0 && p <= 1; });
}

void check_finite(const Image<float>& image, const std::string& name) {
  require_all(image, name, "finite", [](float x) { return std::isfinite(x); });
}

void check_not_negative(const Image<float>& image, const std::string& name) {
  require_all(image, name, "a size", [](float x) { return x >= 0; });
}

void check_layers(const GridLayers& layers, const std::string& name) {
  check_probabilities(layers.occupancy, name + ".occupancy");
  check_probabilities(layers.moving, name + ".moving");
  check_not_negative(layers.age_s, name + ".age_s");
  check_finite(layers.velocity_x, name + ".velocity_x");
  check_finite(layers.velocity_y, name + ".velocity_y");
  check_finite(layers.velocity_xy, name + ".velocity_xy");
  for (const auto* variance : {&layers.velocity_xx, &layers.velocity_yy}) {
    check_finite(*variance, name + "'s velocity variance");
    check_not_negative(*variance, name + "'s velocity variance");
  }
  const GridGeometry& geometry{layers.geometry};
  require(std::isfinite(geometry.x_min_m) && std::isfinite(geometry.y_min_m), name + " is nowhere");
}

void check_obstacle(const Obstacle& o) {
  const std::vector<double> numbers{o.x_m,
                                    o.y_m,
                                    o.vx_mps,
                                    o.vy_mps,
                                    o.length_m,
                                    o.width_m,
                                    o.yaw_rad,
                                    o.occupancy,
                                    o.age_s,
                                    o.unseen_s,
                                    o.position_covariance.xx,
                                    o.position_covariance.xy,
                                    o.position_covariance.yy,
                                    o.velocity_covariance.xx,
                                    o.velocity_covariance.xy,
                                    o.velocity_covariance.yy};
  require_all(numbers, "an obstacle", "finite", [](double x) { return std::isfinite(x); });
  require(o.occupancy >= 0 && o.occupancy <= 1, "an obstacle's occupancy is no probability");
  require(o.length_m >= 0 && o.width_m >= 0 && o.age_s >= 0 && o.unseen_s >= 0, "an obstacle has a negative size");
}

void check_ground(const Ground& ground) {
  const std::vector<double> numbers{ground.height_m,       ground.pitch_rad,       ground.roll_rad,
                                    ground.height_sigma_m, ground.pitch_sigma_rad, ground.roll_sigma_rad};
  require_all(numbers, "the ground", "finite", [](double x) { return std::isfinite(x); });
  require(ground.height_m > 0, "the camera is under the ground");
}

void check_stages(const StageImages& stages) {
  for (const auto* disparity : {&stages.obstacle_disparity, &stages.road_disparity}) {
    check_finite(*disparity, "a disparity");
    check_not_negative(*disparity, "a disparity");
  }
  check_probabilities(stages.match_confidence, "match_confidence");
  check_probabilities(stages.visibility, "visibility");
  check_probabilities(stages.obstacle_confidence, "obstacle_confidence");
  check_probabilities(stages.road_confidence, "road_confidence");
  check_probabilities(stages.occupancy, "stages.occupancy");
  check_probabilities(stages.occupancy_smooth, "stages.occupancy_smooth");
}

}  // namespace

void check_result(const FrameResult& result) {
  check_ground(result.ground);
  const Pose2& pose{result.world_from_vehicle};
  require(std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad), "a pose is not finite");
  require(result.obstacle_density >= 0 && result.obstacle_density <= 1, "a density is no share");
  require(result.road_density >= 0 && result.road_density <= 1, "a density is no share");
  check_probabilities(result.observed, "observed");
  check_layers(result.vehicle, "vehicle");
  check_layers(result.world, "world");
  for (const Prediction& prediction : result.predictions) {
    check_probabilities(prediction.occupancy, "a prediction");
    check_probabilities(prediction.world_occupancy, "a prediction");
  }
  std::ranges::for_each(result.obstacles, check_obstacle);
  check_stages(result.stages);
  require(std::ranges::is_sorted(result.status), "the status is out of order");
}

}  // namespace stereogrid::fuzz
