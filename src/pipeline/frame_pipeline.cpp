// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backend/cpu.hpp"
#include "ground/fit.hpp"
#include "observation/rays/rays.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stopwatch.hpp"

namespace stereogrid {
namespace {

/// Frames between two searches for a lost ground plane.
constexpr int pause_frames{3};

auto ranges_of(Cpu& cpu) {
  return [&cpu](int count, const auto& work) { cpu.for_ranges(count, 8, work); };
}

}  // namespace

FramePipeline::FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                             PixelMask mask, double turned_rad, bool extrinsics_given)
    : config_{config},
      rig_{level_rig},
      turned_rad_{turned_rad},
      has_given_extrinsics_{extrinsics_given},
      cpu_{cpu},
      mask_{std::move(mask)},
      stages_{std::move(stages)},
      window_{vehicle_grid_of(config.grid)},
      ground_{calibrated_ground(rig_, config.ground)},
      validator_{rig_, config.ground, config.matching.disparities},
      extrinsics_search_{rig_, config.ground, turned_rad, extrinsics_given},
      alignment_{rig_},
      scene_flow_{rig_},
      tracker_{config.tracking, rig_},
      near_{rig_, config.matching, window_.cells()},
      ground_samples_{rig_.width_px, rig_.height_px},
      velocity_evidence_{window_.cells(), velocity_axis(config.filter), scene_flow_.points_reserved()},
      clusters_{rig_, config.u_disparity, config.matching.disparities, scene_flow_.points_reserved()} {
  if (config.ground.model == GroundModel::terrain) {
    terrain_.emplace(rig_, config, vehicle_grid_of(config.grid), window_.cells());
  }
  extrinsics_samples_.reserve(samples_max(rig_));
  stages_->set_mask(mask_);
}

void FramePipeline::process(const LevelFrame& frame, FrameResult& result) {
  if (frame.restarts) reset();
  const GridGeometry window{window_.at(frame.world_from_vehicle)};
  const GroundBefore before{ground_, predicted(rig_, config_.ground, ground_, frame.dt_s)};
  flow_ms_ = track_ms_ = terrain_ms_ = 0;

  stages_->begin(frame, window, is_first_, result);
  match(before.expected, false);  // III-C
  std::span<const VelocityEvidence> velocities;
  beside([&] { stages_->estimate_ground(); }, [&] { velocities = track_features(frame, window); });
  compare_near(frame, before.expected, window);
  const bool is_aligned{find_ground(frame, before.expected)};  // first frame, or ground lost

  find_terrain(frame, window, result);
  find_blur(frame);

  Rejection rejection;
  beside([&] { observe_and_filter(true, velocities); },  // IV, V-A, V-B
         [&] {
           if (!is_aligned) align(frame, before.expected);
           rejection = validate(frame);
           if (rejection == Rejection::none) find_segments(frame);
         });
  rejection = settle(frame, rejection, before, result);
  const bool is_usable{rejection == Rejection::none};
  if (!is_usable) {  // rejected: again from the state before the frame
    observe_and_filter(false, {});
    FrameTerrain::clear(result);
  }
  stages_->finish();
  if (!is_usable) set_unknown(result.stages);
  bound_filtered(frame, is_usable, result);

  is_first_ = false;
  cpu_.together([&] { update_tracks(frame, is_usable, result); },
                [&] {
                  if (is_usable) add_features(frame);
                });
  result.timing_ms.ground += terrain_ms_;
  result.timing_ms.flow = flow_ms_;
  result.timing_ms.track = track_ms_;
}

// Runs host work while the stages work: on the CPU on other threads, on a device after the calls have been enqueued.
template <class StageCalls, class HostWork>
void FramePipeline::beside(const StageCalls& stage_calls, const HostWork& host_work) {
  if (!stages_->is_asynchronous()) return cpu_.together(stage_calls, host_work);
  stage_calls();
  host_work();
}

void FramePipeline::match(const Ground& expected, bool estimates_ground) {
  stages_->match(expected, ground_, alignment_);
  if (estimates_ground) stages_->estimate_ground();
}

void FramePipeline::observe_and_filter(bool is_usable, std::span<const VelocityEvidence> velocities) {
  stages_->observe(is_usable, near_.held(is_usable).cells);
  stages_->filter(velocities);
}

void FramePipeline::bound_filtered(const LevelFrame& frame, bool is_usable, FrameResult& result) {
  const bool is_joint{config_.filter.model == FilterModel::joint};
  if (is_usable && is_joint) {
    ranges_of(cpu_)(result.observed.height(),
                    [&](int begin, int end) { correct_by_frame(result.observed.view(), begin, end, result.vehicle); });
  }
  if (terrain_) terrain_->bound_filtered(frame.world_from_vehicle, is_usable, result);
  if (is_joint) complete_unobserved(frame.world_from_vehicle, result);
}

void FramePipeline::find_terrain(const LevelFrame& frame, const GridGeometry& window, FrameResult& result) {
  if (!terrain_) return;
  const ScopedTimer timer{terrain_ms_};
  const GridInVehicle window_cells{grid_in_vehicle(window, inverse(frame.world_from_vehicle))};
  const Ground& ground{stages_->ground()};
  terrain_->find(stages_->obstacle_disparity(), stages_->road_disparity(), ground, slope_.value_or(ground),
                 window_cells, ranges_of(cpu_), result);
  stages_->set_rules(terrain_->rules());
}

// The noise of disparities that are rounded or smoothed by the matcher does not show their errors.
void FramePipeline::find_blur(const LevelFrame& frame) {
  const MatchingConfig& matching{config_.matching};
  const bool is_own{!frame.is_given()};
  if (is_own && (!matching.subpixel || matching.method != MatchingMethod::correlation))
    return stages_->set_blur(widest_blur_px);
  if (!is_own && matching.external_sigma_px > 0) return stages_->set_blur(blur_of(matching.external_sigma_px));
  const float rounded_px{blur_of(frame.disparity_step_px / std::sqrt(12.0))};
  stages_->set_blur(std::max(rounded_px, blur_of(stages_->matches_on_lattice(), matching.window_px)));
}

FlowFrame FramePipeline::flow_frame(const LevelFrame& frame) const {
  return {frame.left,
          frame.right,
          alignment_.offsets(),
          frame.world_from_vehicle,
          frame.dt_s,
          frame.disparity,
          config_.matching.external_sigma_px};
}

std::span<const VelocityEvidence> FramePipeline::track_features(const LevelFrame& frame, const GridGeometry& window) {
  const ScopedTimer timer{flow_ms_};
  config_.filter.scene_flow ? scene_flow_.follow(flow_frame(frame), ranges_of(cpu_)) : scene_flow_.clear();
  if (config_.filter.model != FilterModel::joint) return {};
  return velocity_evidence_.gather(scene_flow_.vectors(), window, ranges_of(cpu_), frame.view);
}

// Selects features to be tracked from the next frame on.
void FramePipeline::add_features(const LevelFrame& frame) {
  const ScopedTimer timer{flow_ms_};
  if (config_.filter.scene_flow)
    scene_flow_.add_points(flow_frame(frame), stages_->matches_on_lattice(), ranges_of(cpu_));
}

// Measures the vertical misalignment in matches on the expected ground.
void FramePipeline::align(const LevelFrame& frame, const Ground& expected) {
  if (!config_.matching.align_rows || frame.right.empty()) return;
  alignment_.update(frame.left, frame.right, stages_->matches_on_lattice(), road_plane(rig_, expected),
                    ranges_of(cpu_));
}

// The road hypothesis needs a plane before there are disparities: that of the frame before. In the first frame, and
// where the ground is lost, a plane is searched in all matches, and the frame is matched again. Returns whether the
// misalignment has been measured.
bool FramePipeline::find_ground(const LevelFrame& frame, const Ground& expected) {
  const bool searches{will_search()};
  if (is_first_ || searches) {
    align(frame, expected);
    if (is_first_ && !alignment_.is_identity()) {
      match(expected);
      align(frame, expected);
    }
    if (searches) search();
  }
  if (terrain_) keep_near_ground(frame, expected, searches);
  find_slope(frame);
  return is_first_ || searches;
}

// A slope, stairs or a lower floor ahead can attract the estimated plane. The plane through the nearest ground alone
// stays if it fits that clearly better.
void FramePipeline::keep_near_ground(const LevelFrame& frame, const Ground& expected, bool has_searched) {
  constexpr double clearly_better{0.8};
  constexpr double near_part{0.7};  // up to 1.4 times the nearest distance
  if (!config_.ground.estimate) return;
  extrinsics_samples_.clear();
  add_samples(matched(frame), extrinsics_samples_);
  const RoadPlane plane{road_plane(rig_, expected)};
  ground_samples_.samples.clear();
  const double first_row{rig_.height_px - (1 - near_part) * plane.disparity(rig_.cx_px, rig_.height_px) / plane.per_v};
  add_samples(stages_->obstacle_disparity(), first_row, ground_samples_.samples);
  add_samples(stages_->road_disparity(), first_row, ground_samples_.samples);
  const Ground near{fit_ground(rig_, config_.ground, expected, ground_samples_)};
  const NearGround fitted{near_ground(rig_, extrinsics_samples_, plane, road_plane(rig_, near), near_part)};
  const NearGround estimated{
      near_ground(rig_, extrinsics_samples_, plane, road_plane(rig_, stages_->ground()), near_part)};
  if (!fitted.holds() || fitted.misfit_px >= clearly_better * estimated.misfit_px) return;
  if (frame.is_given() || has_searched) match(near, false);
  stages_->set_ground(near);
}

// Matches on a slope that fills the view and contradicts the given extrinsics. Their plane stays the ground, and the
// slope is relief over it.
void FramePipeline::find_slope(const LevelFrame& frame) {
  slope_ = std::nullopt;
  if (!terrain_ || !config_.ground.estimate || !has_measured_ground_) return;
  const Ground used{stages_->ground()};
  const RoadPlane plane{road_plane(rig_, used)};
  const auto holds = [&] {
    return near_ground(rig_, extrinsics_samples_, plane, plane, nearest_part).holds() ||
           !contradict(rig_, extrinsics_samples_, plane);
  };
  if (is_within_gates(rig_, config_.ground, used) && !is_jump(used) && holds()) return extrinsics_search_.leave_slope();
  const Point2 place{frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m};
  slope_ = extrinsics_search_.find_slope(extrinsics_samples_, place);
  if (!slope_) return;
  match(*slope_, false);
  stages_->set_ground(calibrated_ground(rig_, config_.ground));
}

// A search that has failed is not repeated for some frames.
bool FramePipeline::will_search() {
  if (!config_.ground.estimate) return false;
  if (frames_to_search_ > 0 && --frames_to_search_ > 0) return false;
  return is_first_ || stages_->is_lost();
}

// True: the camera's height above the plane differs from the rig's, and from a measured one before, by more than a
// suspension moves it and one measures wrong.
bool FramePipeline::is_jump(const Ground& found) const {
  const auto differs = [&](double height_m) { return std::abs(found.height_m - height_m) > 0.12 * height_m; };
  return differs(rig_.camera_height_m) &&
         (has_given_extrinsics_ || (has_measured_ground_ && differs(ground_.height_m)));
}

void FramePipeline::search() {
  Ground found{search_ground(rig_, config_.ground, stages_->obstacle_disparity(), stages_->road_disparity(), ground_,
                             ground_samples_)};
  found.estimated = found.estimated && !is_jump(found);
  if (found.estimated) {
    ground_ = found;
  } else {
    frames_to_search_ = pause_frames;
  }
  if (found.estimated) match(ground_);
}

MatchedFrame FramePipeline::matched(const LevelFrame& frame) const {
  return {frame.left, frame.right, stages_->matches_on_lattice(), mask_.view(), frame.is_given()};
}

// Checks the extrinsics. A frame that is matched again on another ground plane is rejected.
Rejection FramePipeline::check_extrinsics(const LevelFrame& frame, Rejection rejection) {
  const bool is_lost{rejection == Rejection::plane_contradicted || rejection == Rejection::road_not_seen};
  if (rejection == Rejection::none && (slope_ || validator_.is_near_ground_known())) return rejection;
  if (rejection == Rejection::identical_images || !extrinsics_search_.is_wanted(is_lost, frame.dt_s)) return rejection;
  extrinsics_samples_.clear();
  add_samples(matched(frame), extrinsics_samples_);
  const std::optional<Ground> candidate{
      extrinsics_search_.look(extrinsics_samples_, ground_, rejection != Rejection::none)};
  if (!candidate) return rejection;
  const Point2 place{frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m};
  if (!extrinsics_search_.may_replace(extrinsics_samples_, ground_, *candidate, place)) {
    disagreeing_ = candidate;
    return rejection == Rejection::none ? Rejection::plane_contradicted : rejection;
  }
  match(*candidate);
  candidate_ = candidate;
  const MatchedFrame again{matched(frame)};
  extrinsics_samples_.clear();
  add_samples(again, extrinsics_samples_);
  const bool holds{!has_few_matches(again, rig_, *candidate, config_.matching.disparities) &&
                   extrinsics_search_.verify(extrinsics_samples_, *candidate)};
  return holds || rejection == Rejection::none ? Rejection::plane_contradicted : rejection;
}

Rejection FramePipeline::validate(const LevelFrame& frame) {
  const bool jumps{is_jump(stages_->ground())};
  ground_ = stages_->ground();
  Rejection rejection{validator_.validate(matched(frame), slope_.value_or(ground_), frame.dt_s)};
  if (jumps && rejection == Rejection::none) rejection.reason = Rejection::plane_contradicted;
  return rejection;
}

// Returns the final reason to reject the frame, after a check of the extrinsics, and sets the result's ground.
Rejection FramePipeline::settle(const LevelFrame& frame, Rejection rejection, const GroundBefore& before,
                                FrameResult& result) {
  disagreeing_ = candidate_ = std::nullopt;
  rejection = check_extrinsics(frame, rejection);
  if (rejection != Rejection::none) {
    // A plane through wrong matches would mislead the next frame; ground that lies elsewhere does not become more
    // plausible by lasting.
    const bool lies_elsewhere{rejection == Rejection::plane_contradicted || rejection == Rejection::falls_away};
    if (config_.ground.estimate) ground_ = lies_elsewhere && has_measured_ground_ ? before.previous : before.expected;
    ground_.estimated = false;
    scene_flow_.clear();
  }
  result.ground = candidate_.value_or(ground_);  // plane of the disparity images
  result.ground.estimated = ground_.estimated;
  has_measured_ground_ = has_measured_ground_ || ground_.estimated;
  report(rejection, result);
  if (disagreeing_) report_disagreement(rig_, turned_rad_, *disagreeing_, result);
  return rejection;
}

void FramePipeline::find_segments(const LevelFrame& frame) {
  const ScopedTimer timer{track_ms_};
  stereogrid::find_segments(stages_->obstacle_disparity(), ground_,
                            terrain_ ? terrain_->rules().relief : Relief<Host>{}, frame.world_from_vehicle,
                            scene_flow_.vectors(), ranges_of(cpu_), clusters_);
}

void FramePipeline::update_tracks(const LevelFrame& frame, bool is_usable, FrameResult& result) {
  const ScopedTimer timer{track_ms_};
  clusters_.clusters.clear();
  if (is_usable) {
    const std::span<const EdgePoint> edges{terrain_ ? terrain_->edges() : std::span<const EdgePoint>{}};
    make_clusters(result.world, frame.world_from_vehicle, scene_flow_.vectors(),
                  {edges, passage_width * config_.vehicle.height_m}, clusters_);
  }
  const HeldObstacles& held{near_.held(is_usable)};
  tracker_.update(result.world, clusters_.clusters, frame.world_from_vehicle, frame.dt_s, held.ids);
  tracker_.report(frame.world_from_vehicle, vehicle_grid_of(config_.grid), result.obstacles);
  near_.update(result, tracker_, ground_, frame.world_from_vehicle, is_usable);
  tell(held, result);
}

// Compares near obstacles of the last frames with the matches: cells that these do not contradict stay occupied.
void FramePipeline::compare_near(const LevelFrame& frame, const Ground& expected, const GridGeometry& window) {
  near_.begin();
  if (near_.empty()) return;
  near_.compare(matched(frame), expected, frame.world_from_vehicle, window);
}

}  // namespace stereogrid
