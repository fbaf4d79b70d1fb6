// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "backend/cpu.hpp"
#include "fusion/fusion.hpp"
#include "matching/checks/external.hpp"
#include "observation/rays/rays.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {
namespace {

auto ranges_of(Cpu& cpu) {
  return [&cpu](int count, const auto& work) { cpu.for_ranges(count, 8, work); };
}

}  // namespace

FramePipeline::FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                             double turned_rad, GroundMode mode)
    : config_{config},
      rig_{level_rig},
      turned_rad_{turned_rad},
      cpu_{cpu},
      stages_{std::move(stages)},
      window_{vehicle_grid_of(config.grid)},
      estimator_{rig_, config.ground, config.matching.disparities, turned_rad},
      first_ground_{first_ground(extrinsics_of(rig_), mode)},
      state_{config, rig_, first_ground_, window_.cells()},
      ground_space_{rig_},
      velocity_evidence_{window_.cells(), velocity_axis(config.filter), state_.scene_flow.points_reserved()},
      clusters_{rig_, config.u_disparity, config.matching.disparities, state_.scene_flow.points_reserved()} {}

std::optional<Ground> FramePipeline::process(const LevelFrame& frame, FrameResult& result) {
  if (frame.restarts) reset();
  StageTimes host;  // times of the host's own stages
  const FrameGrids grids{grids_of(frame)};
  const Ground expected{estimator_.expected(state_.ground, frame.dt_s)};
  const Point2 place{frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m};

  const bool has_own_changed{find_own_surface(frame, place)};
  stages_->match(frame, grids, state_.alignment, {expected});  // III-C, or external disparities
  if (frame.has_external_disparity()) {
    std::string excess{excess_of(frame.disparity, config_.matching.disparities)};
    if (!excess.empty()) result.warnings.push_back({std::move(excess)});
  }
  if (state_.is_first) align_first(frame, grids, expected);
  std::span<const VelocityEvidence> velocities;
  const GroundFit first{stages_->both(
      cpu_, [&] { velocities = track_features(frame, grids.window, host.flow); },
      [&] { return fit_ground(frame, host.ground); })};
  state_.near.compare(matched(frame), expected, frame.world_from_vehicle, grids.window);
  const GroundFit ground{rematch(frame, grids, first, host.ground)};
  const TerrainRules rules{find_terrain(frame, grids, ground, host.ground, result)};
  if (state_.terrain && frame.has_external_disparity())
    stages_->match(frame, grids, state_.alignment, {ground.plane, &rules.relief});

  const auto filter = [&](const Evidence& evidence, std::span<const VelocityEvidence> measured) {
    stages_->observe(frame, grids, evidence, result);  // IV, V-A
    stages_->filter(frame, grids, measured, result);   // V-B
  };
  const Evidence evidence{true, ground.plane, rules, blur_in(frame), state_.near.held(true).cells};
  const Rejection checked{stages_->both(
      cpu_, [&] { filter(evidence, velocities); },
      [&] {
        if (!state_.is_first) align(frame, expected);
        return check(frame, ground, host.track);
      })};
  const SettledGround settled{estimator_.settle(state_.ground, ground, has_matched(checked), frame.dt_s, place)};
  const Rejection rejection{settled.new_extrinsics && checked == Rejection::none ? Rejection::plane_contradicted
                                                                                 : checked};
  const bool is_usable{rejection == Rejection::none};
  if (!is_usable) {  // again from the state before the frame
    filter({.is_usable = false, .held = state_.near.held(false).cells}, {});
    state_.scene_flow.clear();
  }
  publish(frame, ground, rejection, result);

  if (has_own_changed) report(state_.own_surface, result);
  const bool is_own_ground{has_own_changed && !ground.plane.estimated};  // the extrinsics were those over a bonnet
  if (!settled.new_extrinsics)
    state_.ground = is_own_ground ? first_ground(state_.ground.extrinsics, GroundMode::assumed) : settled.state;
  state_.is_first = false;
  cpu_.together([&] { report_too_close(update_tracks(frame, ground, is_usable, result, host.track), result); },
                [&] { add_features(frame, is_usable, host.flow); });
  result.timing_ms.ground += host.ground;
  result.timing_ms.flow = host.flow;
  result.timing_ms.track = host.track;
  return settled.new_extrinsics;
}

// The misalignment of the first frame is measured before its ground is searched, and once more on better matches.
void FramePipeline::align_first(const LevelFrame& frame, const FrameGrids& grids, const Ground& expected) {
  for (int round{0}; round < 2 && align(frame, expected) && !state_.alignment.is_identity(); ++round)
    stages_->match(frame, grids, state_.alignment, {expected});
}

// True: the rows that show the vehicle have changed. Given extrinsics stay without it.
bool FramePipeline::find_own_surface(const LevelFrame& frame, Point2 place) {
  return config_.ground.estimate && state_.ground.mode != GroundMode::given &&
         state_.own_surface.update(frame.left, stages_->mask().view(), place);
}

void FramePipeline::continue_from(const FramePipeline& before) {
  state_.tracker.continue_ids(before.state_.tracker);
  state_.own_surface.continue_from(before.state_.own_surface, turned_rad_ - before.turned_rad_);
}

GroundFit FramePipeline::fit_ground(const LevelFrame& frame, double& ms) {
  const MatchedFrame matches{matched(frame)};
  const ScopedTimer timer{ms};
  estimator_.gather(matches, state_.own_surface.first_row(), ground_space_);
  return estimator_.fit(state_.ground, frame.dt_s, ground_space_);
}

// The road hypothesis needs a plane before there are disparities. A frame whose plane is another one is matched again.
GroundFit FramePipeline::rematch(const LevelFrame& frame, const FrameGrids& grids, const GroundFit& ground,
                                 double& ms) {
  if (ground.wants_rematch || frame.has_external_disparity())
    stages_->match(frame, grids, state_.alignment, {ground.matched_on()});
  if (!ground.wants_rematch) return ground;
  const MatchedFrame matches{matched(frame)};
  const ScopedTimer timer{ms};
  estimator_.gather(matches, state_.own_surface.first_row(), ground_space_);
  return estimator_.refit(state_.ground, ground, ground_space_);
}

FrameGrids FramePipeline::grids_of(const LevelFrame& frame) const {
  const GridGeometry window{window_.at(frame.world_from_vehicle)};
  return {window, grid_in_vehicle(vehicle_grid_of(config_.grid), {}),
          grid_in_vehicle(window, inverse(frame.world_from_vehicle)), state_.is_first};
}

MatchedFrame FramePipeline::matched(const LevelFrame& frame) const {
  return {frame.left, frame.right, stages_->read().lattice, stages_->mask().view(), frame.has_external_disparity()};
}

FlowFrame FramePipeline::flow_frame(const LevelFrame& frame) const {
  return {frame.left, frame.right,     state_.alignment.offsets(),        frame.world_from_vehicle,
          frame.dt_s, frame.disparity, config_.matching.external_sigma_px};
}

std::span<const VelocityEvidence> FramePipeline::track_features(const LevelFrame& frame, const GridGeometry& window,
                                                                double& ms) {
  const ScopedTimer timer{ms};
  SceneFlow& flow{state_.scene_flow};
  config_.filter.scene_flow ? flow.follow(flow_frame(frame), ranges_of(cpu_)) : flow.clear();
  if (config_.filter.model != FilterModel::joint) return {};
  return velocity_evidence_.gather(flow.vectors(), window, ranges_of(cpu_), frame.view);
}

// Selects features to be tracked from the next frame on.
void FramePipeline::add_features(const LevelFrame& frame, bool is_usable, double& ms) {
  if (!is_usable || !config_.filter.scene_flow) return;
  const ScopedTimer timer{ms};
  state_.scene_flow.add_points(flow_frame(frame), stages_->read().lattice, ranges_of(cpu_));
}

// Measures the vertical misalignment in matches on the expected ground.
bool FramePipeline::align(const LevelFrame& frame, const Ground& expected) {
  if (!config_.matching.align_rows || frame.right.empty()) return false;
  return state_.alignment.update(frame.left, frame.right, stages_->read().lattice, road_plane(rig_, expected),
                                 ranges_of(cpu_));
}

TerrainRules FramePipeline::find_terrain(const LevelFrame& frame, const FrameGrids& grids, const GroundFit& ground,
                                         double& ms, FrameResult& result) {
  if (!state_.terrain) return {};
  const ScopedTimer timer{ms};
  const HostMatches& matches{stages_->read()};
  state_.terrain->find(matches.obstacle, matches.road, ground.plane, ground.matched_on(),
                       {grids.window, grids.window_cells, frame.world_from_vehicle, frame.dt_s}, ranges_of(cpu_),
                       result);
  return state_.terrain->rules();
}

// The noise of disparities that are rounded or smoothed by the matcher does not show their errors.
float FramePipeline::blur_in(const LevelFrame& frame) const {
  const MatchingConfig& matching{config_.matching};
  const bool is_own{!frame.has_external_disparity()};
  if (is_own && (!matching.subpixel || matching.method != MatchingMethod::correlation)) return widest_blur_px;
  if (!is_own && matching.external_sigma_px > 0) return blur_of(matching.external_sigma_px);
  const float rounded_px{blur_of(frame.disparity_step_px / std::sqrt(12.0))};
  return std::max(rounded_px, blur_of(stages_->read().lattice, matching.window_px));
}

// Checks the frame, and finds the segments of a usable one.
Rejection FramePipeline::check(const LevelFrame& frame, const GroundFit& ground, double& segments_ms) {
  const MatchedFrame matches{matched(frame)};
  Rejection rejection{check_images(matches, rig_, ground.matched_on(), config_.matching.disparities)};
  if (rejection == Rejection::none) rejection.reason = estimator_.reason_to_reject(state_.ground, ground, frame.dt_s);
  const bool decides_terrain{state_.terrain || !config_.ground.estimate};
  if (rejection == Rejection::none && !decides_terrain && falls_away(matches, rig_, ground.plane))
    rejection.reason = Rejection::falls_away;
  if (!(rejection == Rejection::none)) return rejection;
  const ScopedTimer timer{segments_ms};
  find_segments(stages_->read().obstacle, ground.plane,
                state_.terrain ? state_.terrain->rules().relief : Relief<Host>{}, frame.world_from_vehicle,
                state_.scene_flow.vectors(), ranges_of(cpu_), clusters_);
  return rejection;
}

// Completes the result but for its obstacles. The grids are final from here on.
void FramePipeline::publish(const LevelFrame& frame, const GroundFit& ground, const Rejection& rejection,
                            FrameResult& result) {
  const bool is_usable{rejection == Rejection::none};
  const bool is_joint{config_.filter.model == FilterModel::joint};
  stages_->publish(frame, result);
  result.ground = ground.matched_on();
  result.ground.estimated = ground.plane.estimated && is_usable;
  report(rejection, result);
  if (rejection == Rejection::camera_rolled) report_roll(seen_from(*ground.rolled, turned_rad_), result);
  if (ground.disagreeing) report_disagreement(rig_, turned_rad_, *ground.disagreeing, result);
  if (!is_usable) {
    set_unknown(result.stages);
    FrameTerrain::clear(result);
  } else if (is_joint) {
    ranges_of(cpu_)(result.observed.height(), [&](int begin, int end) {
      correct_by_frame(frame.world_from_vehicle, !frame.has_external_disparity(), begin, end, result);
    });
  }
  if (state_.terrain) {
    const auto claims_free = [&frame](Point2 at) { return claimed(frame.other_grids, at) < 0.5; };
    state_.terrain->bound_filtered(is_usable, frame.other_grids.empty() ? std::function<bool(Point2)>{} : claims_free,
                                   result);
  }
  if (is_joint) complete_unobserved(frame.world_from_vehicle, result);
}

const HeldObstacles& FramePipeline::update_tracks(const LevelFrame& frame, const GroundFit& ground, bool is_usable,
                                                  FrameResult& result, double& ms) {
  const ScopedTimer timer{ms};
  clusters_.clusters.clear();
  if (is_usable) {
    const std::span<const EdgePoint> edges{state_.terrain ? state_.terrain->edges() : std::span<const EdgePoint>{}};
    make_clusters(result.world, frame.world_from_vehicle, state_.scene_flow.vectors(),
                  {edges, passage_width * config_.vehicle.height_m}, clusters_);
  }
  const HeldObstacles& held{state_.near.held(is_usable)};
  Tracker& tracker{state_.tracker};
  tracker.update(result.world, clusters_.clusters, frame.world_from_vehicle, frame.dt_s, held.ids);
  tracker.report(frame.world_from_vehicle, vehicle_grid_of(config_.grid), result.obstacles);
  state_.near.update(result, tracker, ground.plane, frame.world_from_vehicle, is_usable);
  return held;
}

MemoryUse FramePipeline::memory_use() const {
  MemoryUse use{stages_->memory_use()};
  use.host_bytes += sizeof *this + memory_bytes_of(state_, ground_space_, velocity_evidence_, clusters_);
  return use;
}

}  // namespace stereogrid
