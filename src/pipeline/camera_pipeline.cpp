// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "backend/cpu.hpp"
#include "matching/checks/external.hpp"
#include "observation/rays/rays.hpp"

namespace stereogrid {

CameraPipeline::CameraPipeline(CameraSetup setup, Cpu& cpu)
    : config_{setup.config},
      rig_{setup.level_rig},
      turned_rad_{setup.turned_rad},
      cpu_{cpu},
      stages_{std::move(setup.stages)},
      estimator_{rig_, config_, turned_rad_},
      first_ground_{first_ground(extrinsics_of(rig_), setup.mode)},
      state_{config_, rig_, first_ground_, Window{vehicle_grid_of(config_.grid)}.cells()},
      ground_space_{rig_},
      clusters_{rig_, config_.matching.disparities, state_.scene_flow.points_reserved()} {}

void CameraPipeline::begin(CameraFrame& now) {
  const LevelFrame& frame{now.frame};
  if (frame.restarts) reset();
  now.expected = estimator_.expected(state_.ground, frame.dt_s);
  now.result.has_images = true;
  now.has_own_changed = find_own_surface(frame);
  stages_->match(frame, now.grids, state_.alignment, {now.expected});  // III-C, or external disparities
  if (state_.terrain) state_.terrain->move(place_of(now.grids));
  if (frame.has_external_disparity()) {
    std::string excess{excess_of(frame.disparity, config_.matching.disparities)};
    if (!excess.empty()) now.result.warnings.push_back({std::move(excess)});
  }
}

void CameraPipeline::look(CameraFrame& now) {
  const LevelFrame& frame{now.frame};
  if (state_.is_first) align_first(now);
  GroundFit first;
  cpu_.together([&] { track_features(now); }, [&] { first = fit_ground(now); });
  state_.near.compare(matched(frame), now.expected, frame.world_from_camera, now.grids.window);
  now.ground = rematch(now, first);
  now.rules = find_terrain(now);
  if (state_.terrain && frame.has_external_disparity())
    stages_->match(frame, now.grids, state_.alignment, {now.ground.plane, &now.rules.relief});
}

void CameraPipeline::look_at_nothing(const FrameGrids& grids) {
  if (state_.terrain) state_.terrain->find_nothing(place_of(grids));
}

void CameraPipeline::observe(const CameraFrame& now, bool is_usable) {
  const Evidence unknown{.is_usable = false};
  stages_->observe(now.grids, is_usable ? Evidence{true, now.ground.plane, now.rules, blur_in(now.frame)} : unknown,
                   now.result);
}

Rejection CameraPipeline::check(CameraFrame& now) {
  if (!state_.is_first) align(now.frame, now.expected);
  const MatchedFrame matches{matched(now.frame)};
  const GroundFit& ground{now.ground};
  Rejection rejection{check_images(matches, rig_, ground.matched_on(), config_.matching.disparities)};
  if (rejection == Rejection::none)
    rejection.reason = estimator_.reason_to_reject(state_.ground, ground, now.frame.dt_s);
  const bool decides_terrain{state_.terrain || !config_.ground.estimate};
  if (rejection == Rejection::none && !decides_terrain && falls_away(matches, rig_, ground.plane))
    rejection.reason = Rejection::falls_away;
  return rejection;
}

void CameraPipeline::finish_ground(CameraFrame& now) {
  if (!state_.terrain) return;
  const ScopedTimer timer{now.times.ground};
  stages_->finish_ground(*state_.terrain, now.result);
}

void CameraPipeline::find_segments(CameraFrame& now) {
  clusters_.clusters.clear();
  if (!now.is_usable()) return;
  const ScopedTimer timer{now.times.track};
  const Ground& plane{now.ground.plane};
  Relief<Host> relief{state_.terrain ? state_.terrain->rules().relief : Relief<Host>{}};
  const std::span<const ColumnNode> nodes{stages_->find_nodes(plane, relief)};
  stereogrid::find_segments(nodes, plane, relief, now.frame.world_from_camera, state_.scene_flow.vectors(),
                            ranges_of(cpu_), clusters_);
}

void CameraPipeline::settle(CameraFrame& now, const Rejection& checked) {
  const Point2 place{now.frame.world_from_camera.x_m, now.frame.world_from_camera.y_m};
  now.settled = estimator_.settle(state_.ground, now.ground, has_matched(checked), now.frame.dt_s, place);
  now.rejection = now.settled.new_extrinsics && checked == Rejection::none ? Rejection::plane_contradicted : checked;
  if (!now.is_usable()) state_.scene_flow.clear();
}

void CameraPipeline::publish(const CameraFrame& now) {
  const GroundFit& ground{now.ground};
  FrameResult& result{now.result};
  stages_->publish_matches(result);
  result.ground = ground.matched_on();
  result.ground.estimated = ground.plane.estimated && now.is_usable();
  report(now.rejection, result);
  if (now.rejection == Rejection::camera_rolled) report_roll(seen_from(*ground.rolled, turned_rad_), result);
  if (ground.disagreeing) report_disagreement(rig_, turned_rad_, *ground.disagreeing, result);
  if (now.is_usable()) return;
  set_unknown(result.stages);
  FrameTerrain::clear(result);
}

void CameraPipeline::end(const CameraFrame& now) {
  if (now.has_own_changed) report(state_.own_surface, now.result);
  // the extrinsics were those over a bonnet
  const bool is_own_ground{now.has_own_changed && !now.ground.plane.estimated};
  if (!now.settled.new_extrinsics)
    state_.ground = is_own_ground ? first_ground(state_.ground.extrinsics, GroundMode::assumed) : now.settled.state;
  state_.is_first = false;
}

void CameraPipeline::find_clusters(const GridLayers& world, const CameraFrame& now) {
  if (!now.is_usable()) return;
  const std::span<const EdgePoint> edges{state_.terrain ? state_.terrain->edges() : std::span<const EdgePoint>{}};
  make_clusters(world, now.frame.world_from_camera, {edges, passage_width * config_.vehicle.height_m}, clusters_);
}

void CameraPipeline::add_features(CameraFrame& now) {
  if (!now.is_usable() || !config_.filter.scene_flow) return;
  const ScopedTimer timer{now.times.flow};
  state_.scene_flow.add_points(flow_frame(now.frame), stages_->read(), ranges_of(cpu_));
}

void CameraPipeline::continue_from(const CameraPipeline& before) {
  state_.own_surface.continue_from(before.state_.own_surface, turned_rad_ - before.turned_rad_);
}

MemoryUse CameraPipeline::memory_use() const {
  MemoryUse use{stages_->memory_use()};
  use.host_bytes += sizeof *this + memory_bytes_of(state_, ground_space_, clusters_);
  return use;
}

TerrainPlace CameraPipeline::place_of(const FrameGrids& grids) const {
  return {grids.window,     grids.window_cells, grids.frame.world_from_vehicle,
          grids.frame.dt_s, grids.seen_vehicle, grids.seen_window};
}

MatchedFrame CameraPipeline::matched(const LevelFrame& frame) const {
  return {frame.left, frame.right, stages_->read(), stages_->mask().view(), frame.disparity};
}

FlowFrame CameraPipeline::flow_frame(const LevelFrame& frame) const {
  return {frame.left, frame.right,     state_.alignment.offsets(),        frame.world_from_camera,
          frame.dt_s, frame.disparity, config_.matching.external_sigma_px};
}

void CameraPipeline::track_features(CameraFrame& now) {
  const ScopedTimer timer{now.times.flow};
  SceneFlow& flow{state_.scene_flow};
  config_.filter.scene_flow ? flow.follow(flow_frame(now.frame), ranges_of(cpu_)) : flow.clear();
}

// Measures the vertical misalignment in matches on the expected ground.
bool CameraPipeline::align(const LevelFrame& frame, const Ground& expected) {
  if (!config_.matching.align_rows || frame.right.empty()) return false;
  return state_.alignment.update(frame.left, frame.right, stages_->read(), road_plane(rig_, expected), ranges_of(cpu_));
}

// The misalignment of the first frame is measured before its ground is searched, and once more on better matches.
void CameraPipeline::align_first(const CameraFrame& now) {
  for (int round{0}; round < 2 && align(now.frame, now.expected) && !state_.alignment.is_identity(); ++round)
    stages_->match(now.frame, now.grids, state_.alignment, {now.expected});
}

// True: the rows that show the vehicle have changed. Given extrinsics stay without it.
bool CameraPipeline::find_own_surface(const LevelFrame& frame) {
  const Point2 place{frame.world_from_camera.x_m, frame.world_from_camera.y_m};
  return config_.ground.estimate && state_.ground.mode != GroundMode::given &&
         state_.own_surface.update(frame.left, stages_->mask().view(), place);
}

GroundFit CameraPipeline::fit_ground(CameraFrame& now) {
  const MatchedFrame matches{matched(now.frame)};
  const ScopedTimer timer{now.times.ground};
  estimator_.gather(matches, state_.own_surface.first_row(), ground_space_);
  return estimator_.fit(state_.ground, now.frame.dt_s, ground_space_);
}

// The road hypothesis needs a plane before there are disparities. A frame whose plane is another one is matched again.
GroundFit CameraPipeline::rematch(CameraFrame& now, const GroundFit& ground) {
  if (ground.wants_rematch || now.frame.has_external_disparity())
    stages_->match(now.frame, now.grids, state_.alignment, {ground.matched_on()});
  if (!ground.wants_rematch) return ground;
  const MatchedFrame matches{matched(now.frame)};
  const ScopedTimer timer{now.times.ground};
  estimator_.gather(matches, state_.own_surface.first_row(), ground_space_);
  return estimator_.refit(state_.ground, ground, ground_space_);
}

TerrainRules CameraPipeline::find_terrain(CameraFrame& now) {
  if (!state_.terrain) return {};
  const ScopedTimer timer{now.times.ground};
  FrameTerrain& terrain{*state_.terrain};
  terrain.begin(now.ground.plane, now.ground.matched_on());
  terrain.set_noise(stages_->begin_walk(terrain.walk_frame()));
  stages_->begin_low_obstacles(terrain.begin_low_obstacles(), terrain.noise_px());
  stages_->find_ground(terrain, now.result);
  return terrain.rules();
}

// The noise of disparities that are rounded does not show their errors.
float CameraPipeline::blur_in(const LevelFrame& frame) const {
  const MatchingConfig& matching{config_.matching};
  const bool is_own{!frame.has_external_disparity()};
  if (is_own && !matching.subpixel) return widest_blur_px;
  if (!is_own && matching.external_sigma_px > 0) return blur_of(matching.external_sigma_px);
  const float rounded_px{blur_of(frame.disparity_step_px / std::sqrt(12.0))};
  return std::max(rounded_px, blur_of(stages_->read(), matching.window_px));
}

}  // namespace stereogrid
