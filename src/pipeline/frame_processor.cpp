// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/frame_processor.hpp"

#include <cmath>
#include <functional>
#include <utility>

#include "pipeline/results.hpp"
#include "pipeline/stopwatch.hpp"

namespace stereogrid {
namespace {

/// Frames after which a road that was not found is searched again.
constexpr int pause_frames{3};

// The threads of the back end for the host's own work.
auto ranges_of(Stages& stages) {
  return [&stages](int count, const auto& work) { stages.for_ranges(count, std::cref(work)); };
}

template <class Work>
double taken_ms(const Work& work) {
  Stopwatch watch;
  work();
  return watch.lap();
}

}  // namespace

FrameProcessor::FrameProcessor(const Config& config, const Rig& level_rig, std::unique_ptr<Stages> stages,
                               double turned_rad, bool has_given_extrinsics)
    : config_{config},
      rig_{level_rig},
      turned_rad_{turned_rad},
      has_given_extrinsics_{has_given_extrinsics},
      stages_{std::move(stages)},
      window_{vehicle_grid_of(config.grid)},
      ground_{calibrated_ground(rig_, config.ground)},
      trust_{rig_, config.ground, config.matching.disparities},
      mounting_{rig_, config.ground, turned_rad, has_given_extrinsics},
      alignment_{rig_},
      scene_flow_{rig_},
      tracker_{config.tracking, rig_},
      near_{rig_, config.matching, window_.cells()},
      ground_samples_{rig_.width_px, rig_.height_px},
      velocity_evidence_{window_.cells(), velocity_axis(config.filter).back(), scene_flow_.points_reserved()},
      clusters_{rig_, config.u_disparity, config.matching.disparities, scene_flow_.points_reserved()} {
  mounting_samples_.reserve(samples_max(rig_));
}

void FrameProcessor::take_mask(PixelMask mask) {
  mask_ = std::move(mask);
  stages_->take_mask(mask_);
}

void FrameProcessor::start(const LevelFrame& frame, FrameResult& result) {
  ground_before_ = ground_;
  expected_ = predicted(rig_, config_.ground, ground_, frame.dt_s);
  stages_->begin(frame, window_.at(frame.world_from_vehicle), is_first_, result);
  match(expected_, stages_->works_ahead());
}

void FrameProcessor::finish(const LevelFrame& frame, FrameResult& result, const Ahead& ahead) {
  double flow_ms{0};
  const auto follow = [&] { flow_ms += taken_ms([&] { follow_points(frame, window_.at(frame.world_from_vehicle)); }); };
  stages_->works_ahead() ? follow() : together(follow, [this] { stages_->estimate_ground(); });
  is_reliable_ = true;
  has_segments_ = false;
  compare_near(frame);
  double track_ms{find_grids(frame, result)};
  const auto add = [&] { flow_ms += taken_ms([&] { add_points(frame); }); };
  if (stages_->works_ahead()) {
    add();
    if (ahead.images_free) ahead.images_free();
  }
  stages_->finish();
  if (!is_reliable_) leave_unknown(result.stages);
  is_first_ = false;
  if (stages_->works_ahead() && ahead.device_free) ahead.device_free();
  together([&] { track_ms += taken_ms([&] { track(frame, result); }); },
           [&] {
             if (!stages_->works_ahead()) add();
           });
  result.timing_ms.track = track_ms;
  result.timing_ms.flow = flow_ms;
}

// A std::function of the work itself would allocate.
template <class First, class Second>
void FrameProcessor::together(const First& first, const Second& second) {
  stages_->together(std::cref(first), std::cref(second));
}

// Returns what it has taken to find the segments, if they have been found meanwhile, ms.
double FrameProcessor::find_grids(const LevelFrame& frame, FrameResult& result) {
  if (stages_->works_ahead()) {
    make_grids();  // as if nothing were wrong with the frame; what is made twice, counts the second time
    find_road(frame, will_search());
    is_reliable_ = accept(frame, judge(frame), result);
    if (is_reliable_) return taken_ms([&] { find_segments(frame); });
    make_grids();
    return 0;
  }
  const bool searches{will_search()};
  if (!is_first_ && !searches) return find_grids_and_segments(frame, result);
  find_road(frame, searches);
  is_reliable_ = accept(frame, judge(frame), result);
  make_grids();
  return 0;
}

// The frame is not matched again, unless it cannot be used: what reads the matches alone goes on at the same time.
double FrameProcessor::find_grids_and_segments(const LevelFrame& frame, FrameResult& result) {
  Doubt doubt{Doubt::none};
  double segments_ms{0};
  const auto look = [&] {
    measure_rows(frame);
    doubt = judge(frame);
    if (doubt == Doubt::none) segments_ms = taken_ms([&] { find_segments(frame); });
  };
  together([this] { make_grids(); }, look);
  is_reliable_ = accept(frame, doubt, result);
  if (!is_reliable_) make_grids();
  return segments_ms;
}

void FrameProcessor::match(const Ground& expected, bool estimates_ground) {
  stages_->expect(expected, ground_, alignment_);
  stages_->perform(StagePart::match, [this, estimates_ground] {
    stages_->match();
    if (estimates_ground) stages_->estimate_ground();
  });
}

void FrameProcessor::make_grids() {
  stages_->hold(near_.held(is_reliable_).cells);
  stages_->perform(is_reliable_ ? StagePart::grids : StagePart::unknown_grids, [this] {
    if (is_reliable_) {
      stages_->count();
      stages_->project();
    } else {
      stages_->observe_nothing();
    }
    stages_->fuse();
    stages_->filter();
    if (config_.filter.model == FilterModel::joint) stages_->weigh_velocities();
    stages_->resample();
  });
}

FlowFrame FrameProcessor::flow_frame(const LevelFrame& frame) const {
  return {frame.left, frame.right, alignment_.offsets(), frame.world_from_vehicle, frame.dt_s};
}

void FrameProcessor::follow_points(const LevelFrame& frame, const GridGeometry& window) {
  flows(frame) ? scene_flow_.follow(flow_frame(frame), ranges_of(*stages_)) : scene_flow_.clear();
  if (config_.filter.model != FilterModel::joint) return;
  stages_->take_velocities(velocity_evidence_.gather(scene_flow_.vectors(), window, ranges_of(*stages_), frame.view));
}

// To be followed from the next frame on.
void FrameProcessor::add_points(const LevelFrame& frame) {
  if (!is_reliable_ || !flows(frame)) return;
  scene_flow_.add_points(flow_frame(frame), stages_->matches_on_lattice(), ranges_of(*stages_));
}

// From the matches on the road as it was expected.
void FrameProcessor::measure_rows(const LevelFrame& frame) {
  if (!config_.matching.align_rows || frame.is_given()) return;
  alignment_.update(frame.left, frame.right, stages_->matches_on_lattice(), road_plane(rig_, expected_),
                    ranges_of(*stages_));
}

// The road hypothesis needs a plane before there is any disparity: that of the frame before. At the start, and when the
// road turns out to lie elsewhere, a plane is searched in what matched, and the frame is matched again.
void FrameProcessor::find_road(const LevelFrame& frame, bool searches) {
  measure_rows(frame);
  const bool are_rows_off{is_first_ && !alignment_.is_identity()};
  if (are_rows_off) {
    match(expected_);
    measure_rows(frame);
  }
  const bool has_searched{searches && search(frame)};
  if ((has_searched || are_rows_off) && stages_->works_ahead()) make_grids();
}

// After a search that found nothing there is a pause, as it would find nothing again.
bool FrameProcessor::will_search() {
  if (!config_.ground.estimate) return false;
  if (frames_to_search_ > 0 && --frames_to_search_ > 0) return false;
  return is_first_ || stages_->is_lost();
}

// True: the camera's height above the plane differs from the rig's, and from a measured one before, by more than a
// suspension moves it and one measures wrong.
bool FrameProcessor::is_jump(const Ground& found) const {
  const auto differs = [&](double height_m) { return std::abs(found.height_m - height_m) > 0.12 * height_m; };
  return differs(rig_.camera_height_m) &&
         (has_given_extrinsics_ || (has_measured_ground_ && differs(ground_.height_m)));
}

// True: matched again.
bool FrameProcessor::search(const LevelFrame& frame) {
  // a plane far off would have split the wrong pixels away
  const Matches& matches{stages_->unsplit_matches()};
  Ground found{
      search_ground(rig_, config_.ground, matches.obstacle.view(), matches.road.view(), ground_, ground_samples_)};
  found.estimated = found.estimated && !is_jump(found);
  if (found.estimated) {
    ground_ = found;
  } else {
    frames_to_search_ = pause_frames;
  }
  if (!found.estimated && !frame.is_given()) return false;
  match(ground_);
  return true;
}

MatchedFrame FrameProcessor::matched(const LevelFrame& frame) const {
  return {frame.left, frame.right, frame.disparity, stages_->matches_on_lattice(), mask_.view()};
}

// The frame is matched again where the road lies elsewhere, which is doubt enough.
Doubt FrameProcessor::look_at_mounting(const LevelFrame& frame, Doubt doubt) {
  const bool is_lost{doubt == Doubt::road_elsewhere || doubt == Doubt::road_not_seen};
  if (doubt == Doubt::identical_images || !mounting_.is_wanted(is_lost, frame.dt_s)) return doubt;
  mounting_samples_.clear();
  add_samples(matched(frame), mounting_samples_);
  const std::optional<Ground> candidate{mounting_.look(mounting_samples_, ground_, doubt != Doubt::none)};
  if (!candidate) return doubt;
  const Point2 place{frame.world_from_vehicle.x_m, frame.world_from_vehicle.y_m};
  if (!mounting_.may_replace(mounting_samples_, ground_, *candidate, place)) {
    disagreeing_ = candidate;
    return doubt == Doubt::none ? Doubt::road_elsewhere : doubt;
  }
  if (!frame.is_given()) match(*candidate);
  const MatchedFrame again{matched(frame)};
  mounting_samples_.clear();
  add_samples(again, mounting_samples_);
  const bool holds{!has_few_matches(again, rig_, *candidate, config_.matching.disparities) &&
                   mounting_.verify(mounting_samples_, *candidate)};
  return holds || doubt == Doubt::none ? Doubt::road_elsewhere : doubt;
}

Doubt FrameProcessor::judge(const LevelFrame& frame) {
  const bool jumps{is_jump(stages_->ground())};
  ground_ = stages_->ground();
  Doubt doubt{trust_.judge(matched(frame), ground_, frame.dt_s)};
  if (jumps && doubt == Doubt::none) doubt.reason = Doubt::road_elsewhere;
  return doubt;
}

// False: the grids must not be built on this.
bool FrameProcessor::accept(const LevelFrame& frame, Doubt doubt, FrameResult& result) {
  disagreeing_ = std::nullopt;
  doubt = look_at_mounting(frame, doubt);
  if (doubt != Doubt::none) {
    // A plane through wrong matches would mislead the next frame; ground that lies elsewhere does not become more
    // plausible by lasting.
    const bool lies_elsewhere{doubt == Doubt::road_elsewhere || doubt == Doubt::falls_away};
    if (config_.ground.estimate) ground_ = lies_elsewhere && has_measured_ground_ ? ground_before_ : expected_;
    ground_.estimated = false;
    scene_flow_.clear();
    stages_->take_velocities({});
  }
  result.ground = ground_;
  has_measured_ground_ = has_measured_ground_ || ground_.estimated;
  tell(doubt, result);
  if (disagreeing_) tell_disagreement(rig_, turned_rad_, *disagreeing_, result);
  return doubt == Doubt::none;
}

void FrameProcessor::find_segments(const LevelFrame& frame) {
  stereogrid::find_segments(stages_->obstacle_disparity(), ground_, frame.world_from_vehicle, scene_flow_.vectors(),
                            ranges_of(*stages_), clusters_);
  has_segments_ = true;
}

void FrameProcessor::track(const LevelFrame& frame, FrameResult& result) {
  clusters_.clusters.clear();
  if (is_reliable_) {
    if (!has_segments_) find_segments(frame);
    make_clusters(result.world, frame.world_from_vehicle, scene_flow_.vectors(), clusters_);
  }
  const HeldObstacles& held{near_.held(is_reliable_)};
  tracker_.update(result.world, clusters_.clusters, frame.world_from_vehicle, frame.dt_s, held.ids);
  tracker_.report(frame.world_from_vehicle, result.obstacles);
  near_.update(result, ground_, frame.world_from_vehicle, is_reliable_);
  tell(held, result);
}

// Obstacles near the camera, before the grids: cells that the matches do not contradict stay occupied.
void FrameProcessor::compare_near(const LevelFrame& frame) {
  near_.begin();
  if (near_.empty()) return;
  near_.compare(matched(frame), expected_, frame.world_from_vehicle, window_.at(frame.world_from_vehicle));
}

// The rest is working memory, or the first frame resets it.
void FrameProcessor::forget() {
  ground_ = calibrated_ground(rig_, config_.ground);
  frames_to_search_ = 0;
  is_first_ = true;
  has_measured_ground_ = false;
  alignment_ = RowAlignment{rig_};
  trust_ = FrameTrust{rig_, config_.ground, config_.matching.disparities};
  mounting_.begin_again();
  scene_flow_ = SceneFlow{rig_};
  tracker_.forget();
  near_.clear();
}

void FrameProcessor::follow_on(const FrameProcessor& before) {
  tracker_.go_on_from(before.tracker_);
}

template <class State>
void FrameProcessor::exchange(State& state) {
  state(ground_, frames_to_search_, is_first_, has_measured_ground_, alignment_, trust_, mounting_, scene_flow_,
        tracker_, near_);
}

void FrameProcessor::save(StateWriter& state) {
  exchange(state);
  stages_->save(state);
}

void FrameProcessor::load(StateReader& state) {
  exchange(state);
  stages_->load(state);
}

MemoryUse FrameProcessor::memory_use() const {
  MemoryUse use{stages_->memory_use()};
  use.host_bytes += sizeof *this + held_bytes_of(mask_, trust_, alignment_, scene_flow_, tracker_, near_,
                                                 ground_samples_, mounting_samples_, velocity_evidence_, clusters_);
  return use;
}

}  // namespace stereogrid
