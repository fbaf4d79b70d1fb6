// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "paper_preset.hpp"

namespace stereogrid {
namespace {

void set_values(GridConfig& grid) {
  grid.length_m = 20;
  grid.width_m = 20;
  grid.cell_size_m = 0.2;
}

void set_values(MatchingConfig& matching) {
  matching.method = MatchingMethod::correlation;
  matching.align_rows = false;
  matching.disparities = 0;
  matching.min_disparity = 0;
  matching.window_px = 21;
  matching.road_margin_px = 3;
  matching.uniqueness = 0.02;
  matching.texture = 1;
  matching.cost_limit = 1;
  matching.left_right_px = 1;
  matching.speckle_px = 60;
  matching.road_speckle_px = 60;
  matching.subpixel = false;
  matching.penalty_step = 7;
  matching.penalty_jump = 40;
  matching.penalty_change = 20;
  matching.given_sigma_px = 0.5;
  matching.given_height_m = 0.15;
}

void set_values(GroundConfig& ground) {
  ground.estimate = true;
  ground.height_gate_m = 0.25;
  ground.pitch_gate_deg = 4.5;
  ground.roll_gate_deg = 6;
  ground.height_noise_m = 0.03;
  ground.pitch_noise_deg = 0.5;
  ground.roll_noise_deg = 0.5;
}

void set_values(UDisparityConfig& u_disparity) {
  u_disparity.obstacle_height_m = 1.8;
  u_disparity.obstacle_min_height_m = 0;
  u_disparity.follow_roll = false;
  u_disparity.false_positive = 0.02;
  u_disparity.false_negative = 0.02;
  u_disparity.tau_obstacle = 0.1;
  u_disparity.tau_road = 0.1;
  u_disparity.sigma_disparity = 0.5;
  u_disparity.sigma_column = 1.5;
  u_disparity.road_rays = RoadRays::none;
  u_disparity.small_count_guard = 0;
  u_disparity.left_border = false;
}

void set_values(ProjectionConfig& projection) {
  projection.model = ProjectionModel::bins;
}

void set_values(FusionConfig& fusion) {
  fusion.stereo_confidence = 0.95;
  fusion.other_confidence = 1;
}

void set_values(MotionConfig& motion) {
  motion.notice_jumps = true;
  motion.speed_max_mps = 70;
  motion.acceleration_max_mps2 = 12;
  motion.yaw_rate_max_degps = 120;
  motion.yaw_acceleration_max_degps2 = 180;
  motion.jump_min_m = 0.3;
  motion.jump_min_deg = 1;
  motion.gap_max_s = 5;
}

void set_values(FilterConfig& filter) {
  filter.model = FilterModel::tay2008;
  filter.speeds_mps = {2, 4, 6, 8, 10};
  filter.forgetting_s = 2;
  filter.forgetting_in_view_s = 2;
  filter.velocity_noise = 0.05;
  filter.likelihood_exponent = 1;
  filter.static_prior = 0;
  filter.appearing_static = 0.4;
  filter.border_occupancy = 0.2;
  filter.scene_flow = false;
}

void set_values(TrackingConfig& tracking) {
  tracking.gate_m = 1.5;
  tracking.confirm_frames = 3;
  tracking.coast_s = 1;
  tracking.acceleration_mps2 = 4;
}

}  // namespace

void set_paper_values(Config& config) {
  Config::visit_groups(config, [](std::string_view, auto& group) { set_values(group); });
}

}  // namespace stereogrid
