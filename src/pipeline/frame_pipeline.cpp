// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "backend/cpu.hpp"
#include "observation/rays/rays.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stopwatch.hpp"

namespace stereogrid {
namespace {

auto ranges_of(Cpu& cpu) {
  return [&cpu](int count, const auto& work) { cpu.for_ranges(count, 8, work); };
}

}  // namespace

FramePipeline::FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                             double turned_rad, bool extrinsics_given)
    : config_{config},
      rig_{level_rig},
      turned_rad_{turned_rad},
      cpu_{cpu},
      stages_{std::move(stages)},
      window_{vehicle_grid_of(config.grid)},
      estimator_{rig_, config, turned_rad, extrinsics_given},
      state_{config, rig_, estimator_, window_.cells()},
      velocity_evidence_{window_.cells(), velocity_axis(config.filter), state_.scene_flow.points_reserved()},
      clusters_{rig_, config.u_disparity, config.matching.disparities, state_.scene_flow.points_reserved()} {}

void FramePipeline::process(const LevelFrame& frame, FrameResult& result) {
  if (frame.restarts) reset();
  StageTimes host;  // times of the host's own stages
  const FrameGrids grids{grids_of(frame)};
  const FrameMoment moment{{frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m}, frame.dt_s};
  const GroundBefore before{state_.ground.plane, estimator_.expected(state_.ground, frame.dt_s)};
  const auto rematch = [&](const Ground& plane, bool wants_fit) {
    match(frame, grids, {plane, state_.ground.plane});
    if (wants_fit) stages_->fit_plane(frame);
    return stages_->read().fit;
  };

  match(frame, grids, {before.expected, before.previous});  // III-C, or external disparities
  const std::span<const VelocityEvidence> velocities{stages_->both(
      cpu_, [&] { stages_->fit_plane(frame); }, [&] { return track_features(frame, grids.window, host.flow); })};
  state_.near.compare(matched(frame), before.expected, frame.world_from_vehicle, grids.window);

  const FoundGround found{find_ground(frame, before, moment, std::cref(rematch))};
  const GroundFit& ground{found.ground};
  const TerrainRules rules{find_terrain(frame, grids, ground, host.ground, result)};
  if (state_.terrain && frame.has_external_disparity()) match(frame, grids, {ground.plane, {}, &rules.relief});

  const auto filter = [&](const Evidence& evidence, std::span<const VelocityEvidence> measured) {
    stages_->observe(frame, grids, evidence, result);  // IV, V-A
    stages_->filter(frame, grids, measured, result);   // V-B
  };
  const Evidence evidence{true, ground.plane, rules, blur_in(frame), state_.near.held(true).cells};
  const Rejection rejection{stages_->both(
      cpu_, [&] { filter(evidence, velocities); },
      [&] {
        if (!found.is_aligned) align(frame, before.expected);
        return check(frame, ground, host.track);
      })};
  const Verdict verdict{
      estimator_.settle(state_.ground, matched(frame), ground, rejection, before, moment, std::cref(rematch))};
  if (!verdict.is_usable()) {  // again from the state before the frame
    filter({.is_usable = false, .held = state_.near.held(false).cells}, {});
    state_.scene_flow.clear();
  }
  publish(frame, verdict, result);

  state_.is_first = false;
  cpu_.together([&] { report_too_close(update_tracks(frame, verdict.is_usable(), result, host.track), result); },
                [&] { add_features(frame, verdict.is_usable(), host.flow); });
  result.timing_ms.ground += host.ground;
  result.timing_ms.flow = host.flow;
  result.timing_ms.track = host.track;
}

// In the first frame, and where the ground is lost, the misalignment is measured before the ground is searched.
FramePipeline::FoundGround FramePipeline::find_ground(const LevelFrame& frame, const GroundBefore& before,
                                                      const FrameMoment& moment,
                                                      const GroundEstimator::Rematch& rematch) {
  const bool searches{estimator_.wants_search(state_.ground, state_.is_first, stages_->read().fit)};
  const bool is_aligned{searches || state_.is_first};
  if (is_aligned) align(frame, before.expected);
  if (state_.is_first && !state_.alignment.is_identity()) {
    rematch(before.expected, true);
    align(frame, before.expected);
  }
  return {estimator_.fit(state_.ground, matched(frame), before.expected, searches, moment.place, rematch), is_aligned};
}

FrameGrids FramePipeline::grids_of(const LevelFrame& frame) const {
  const GridGeometry window{window_.at(frame.world_from_vehicle)};
  return {window, grid_in_vehicle(vehicle_grid_of(config_.grid), {}),
          grid_in_vehicle(window, inverse(frame.world_from_vehicle)), state_.is_first};
}

void FramePipeline::match(const LevelFrame& frame, const FrameGrids& grids, const MatchGround& ground) {
  stages_->match(frame, grids, state_.alignment, ground);
}

MatchedFrame FramePipeline::matched(const LevelFrame& frame) const {
  const HostMatches& matches{stages_->read()};
  return {frame.left,       frame.right,  matches.lattice, stages_->mask().view(), frame.has_external_disparity(),
          matches.obstacle, matches.road, matches.fit};
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
  const MatchedFrame matches{matched(frame)};
  state_.terrain->find(matches.obstacle, matches.road, ground.plane, ground.matched_on(), grids.window_cells,
                       ranges_of(cpu_), result);
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

// Validates the frame, and finds the segments of a valid one.
Rejection FramePipeline::check(const LevelFrame& frame, const GroundFit& ground, double& segments_ms) {
  const MatchedFrame matches{matched(frame)};
  const Rejection rejection{estimator_.validate(state_.ground, matches, ground, frame.dt_s)};
  if (rejection != Rejection::none) return rejection;
  const ScopedTimer timer{segments_ms};
  find_segments(matches.obstacle, ground.plane, state_.terrain ? state_.terrain->rules().relief : Relief<Host>{},
                frame.world_from_vehicle, state_.scene_flow.vectors(), ranges_of(cpu_), clusters_);
  return rejection;
}

// Completes the result but for its obstacles. The grids are final from here on.
void FramePipeline::publish(const LevelFrame& frame, const Verdict& verdict, FrameResult& result) {
  const bool is_usable{verdict.is_usable()};
  const bool is_joint{config_.filter.model == FilterModel::joint};
  stages_->publish(frame, result);
  result.ground = verdict.plane;
  report(verdict.rejection, result);
  if (verdict.disagreeing) report_disagreement(rig_, turned_rad_, *verdict.disagreeing, result);
  if (!is_usable) {
    set_unknown(result.stages);
    FrameTerrain::clear(result);
  } else if (is_joint) {
    ranges_of(cpu_)(result.observed.height(),
                    [&](int begin, int end) { correct_by_frame(result.observed.view(), begin, end, result.vehicle); });
  }
  if (state_.terrain) state_.terrain->bound_filtered(frame.world_from_vehicle, is_usable, result);
  if (is_joint) complete_unobserved(frame.world_from_vehicle, result);
}

const HeldObstacles& FramePipeline::update_tracks(const LevelFrame& frame, bool is_usable, FrameResult& result,
                                                  double& ms) {
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
  state_.near.update(result, tracker, state_.ground.plane, frame.world_from_vehicle, is_usable);
  return held;
}

MemoryUse FramePipeline::memory_use() const {
  MemoryUse use{stages_->memory_use()};
  use.host_bytes += sizeof *this + held_bytes_of(estimator_, state_, velocity_evidence_, clusters_);
  return use;
}

}  // namespace stereogrid
