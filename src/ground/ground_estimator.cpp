// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/ground_estimator.hpp"

#include <cmath>

#include "ground/fit.hpp"

namespace stereogrid {
namespace {

/// Frames between two searches for a lost ground plane.
constexpr int pause_frames{3};

}  // namespace

GroundEstimator::GroundEstimator(const Rig& level_rig, const Config& config, double turned_rad, bool extrinsics_given)
    : rig_{level_rig},
      config_{config},
      turned_rad_{turned_rad},
      has_given_extrinsics_{extrinsics_given},
      space_{rig_.width_px, rig_.height_px} {
  samples_.reserve(samples_max(rig_));
}

GroundState GroundEstimator::initial() const {
  return {.plane = calibrated_ground(rig_, config_.ground),
          .validator = {rig_, config_.ground, config_.matching.disparities},
          .extrinsics = {rig_, config_.ground, turned_rad_, has_given_extrinsics_}};
}

void GroundEstimator::restart(GroundState& state) const {
  GroundState next{initial()};
  next.extrinsics = state.extrinsics;
  next.extrinsics.begin_again();
  state = next;
}

Ground GroundEstimator::expected(const GroundState& state, double dt_s) const {
  return predicted(rig_, config_.ground, state.plane, dt_s);
}

bool GroundEstimator::wants_search(GroundState& state, bool is_first, const PlaneFit& fit) const {
  if (!config_.ground.estimate) return false;
  if (state.frames_to_search > 0 && --state.frames_to_search > 0) return false;
  return is_first || fit.is_lost;
}

void GroundEstimator::sample(const MatchedFrame& frame) {
  samples_.clear();
  add_samples(frame, samples_);
}

// The road hypothesis needs a plane before there are disparities: that of the frame before. In the first frame, and
// where the ground is lost, a plane is searched in all matches, and the frame is matched again.
GroundFit GroundEstimator::fit(GroundState& state, const MatchedFrame& frame, const Ground& expected, bool searches,
                               Point2 place, const Rematch& rematch) {
  const PlaneFit found{searches ? search(state, frame, frame.fit, rematch) : frame.fit};
  if (config_.ground.model != GroundModel::terrain || !config_.ground.estimate) return {found.plane};
  const Ground near{keep_near_ground(frame, expected, found.plane, searches, rematch)};
  const std::optional<Ground> slope{find_slope(state, near, place, rematch)};
  return slope ? GroundFit{calibrated_ground(rig_, config_.ground), slope} : GroundFit{near};
}

PlaneFit GroundEstimator::search(GroundState& state, const MatchedFrame& frame, const PlaneFit& fit,
                                 const Rematch& rematch) {
  Ground found{search_ground(rig_, config_.ground, frame.obstacle, frame.road, state.plane, space_)};
  found.estimated = found.estimated && !is_jump(state, found);
  if (!found.estimated) {
    state.frames_to_search = pause_frames;
    return fit;
  }
  state.plane = found;
  return rematch(found, true);
}

// True: the camera's height above the plane differs from the rig's, and from a measured one before, by more than a
// suspension moves it and one measures wrong.
bool GroundEstimator::is_jump(const GroundState& state, const Ground& found) const {
  const auto differs = [&](double height_m) { return std::abs(found.height_m - height_m) > 0.12 * height_m; };
  return differs(rig_.camera_height_m) &&
         (has_given_extrinsics_ || (state.has_been_measured && differs(state.plane.height_m)));
}

// A slope, stairs or a lower floor ahead can attract the estimated plane. The plane through the nearest ground alone
// stays if it fits that clearly better.
Ground GroundEstimator::keep_near_ground(const MatchedFrame& frame, const Ground& expected, const Ground& estimated,
                                         bool has_searched, const Rematch& rematch) {
  constexpr double clearly_better{0.8};
  constexpr double near_part{0.7};  // up to 1.4 times the nearest distance
  sample(frame);
  const RoadPlane plane{road_plane(rig_, expected)};
  space_.samples.clear();
  const double first_row{rig_.height_px - (1 - near_part) * plane.disparity(rig_.cx_px, rig_.height_px) / plane.per_v};
  add_samples(frame.obstacle, first_row, space_.samples);
  add_samples(frame.road, first_row, space_.samples);
  const Ground near{fit_ground(rig_, config_.ground, expected, space_)};
  const NearGround fitted{near_ground(rig_, samples_, plane, road_plane(rig_, near), near_part)};
  const NearGround of_all{near_ground(rig_, samples_, plane, road_plane(rig_, estimated), near_part)};
  if (!fitted.holds() || fitted.misfit_px >= clearly_better * of_all.misfit_px) return estimated;
  if (frame.is_external || has_searched) rematch(near, false);
  return near;
}

// A slope that fills the view and contradicts the given extrinsics is matched on. Their plane stays the ground, and the
// slope is relief over it.
std::optional<Ground> GroundEstimator::find_slope(GroundState& state, const Ground& used, Point2 place,
                                                  const Rematch& rematch) {
  if (!state.has_been_measured) return std::nullopt;
  const RoadPlane plane{road_plane(rig_, used)};
  const auto holds = [&] {
    return near_ground(rig_, samples_, plane, plane, nearest_part).holds() || !contradict(rig_, samples_, plane);
  };
  if (is_within_gates(rig_, config_.ground, used) && !is_jump(state, used) && holds()) {
    state.extrinsics.leave_slope();
    return std::nullopt;
  }
  const std::optional<Ground> slope{state.extrinsics.find_slope(samples_, place)};
  if (slope) rematch(*slope, false);
  return slope;
}

Rejection GroundEstimator::validate(GroundState& state, const MatchedFrame& frame, const GroundFit& fit,
                                    double dt_s) const {
  const bool jumps{is_jump(state, fit.plane)};
  state.plane = fit.plane;
  Rejection rejection{state.validator.validate(frame, fit.matched_on(), dt_s)};
  if (jumps && rejection == Rejection::none) rejection.reason = Rejection::plane_contradicted;
  return rejection;
}

// Checks the extrinsics. A frame that is matched again on another ground plane is rejected.
GroundEstimator::Checked GroundEstimator::check_extrinsics(GroundState& state, const MatchedFrame& frame,
                                                           const GroundFit& fit, const Rejection& rejection,
                                                           const FrameMoment& moment, const Rematch& rematch) {
  const bool is_accepted{rejection == Rejection::none};
  const bool is_lost{rejection == Rejection::plane_contradicted || rejection == Rejection::road_not_seen};
  if (is_accepted && (fit.slope || state.validator.is_near_ground_known())) return {rejection};
  if (rejection == Rejection::identical_images || !state.extrinsics.is_wanted(is_lost, moment.dt_s)) return {rejection};
  sample(frame);
  const std::optional<Ground> candidate{state.extrinsics.look(samples_, state.plane, !is_accepted)};
  if (!candidate) return {rejection};
  const Rejection contradicted{is_accepted ? Rejection{Rejection::plane_contradicted} : rejection};
  if (!state.extrinsics.may_replace(samples_, state.plane, *candidate, moment.place)) return {contradicted, candidate};
  rematch(*candidate, true);
  sample(frame);
  const bool holds{!has_few_matches(frame, rig_, *candidate, config_.matching.disparities) &&
                   state.extrinsics.verify(samples_, *candidate)};
  return {holds ? Rejection::plane_contradicted : contradicted, {}, candidate};
}

Verdict GroundEstimator::settle(GroundState& state, const MatchedFrame& frame, const GroundFit& fit,
                                const Rejection& rejection, const GroundBefore& before, const FrameMoment& moment,
                                const Rematch& rematch) {
  const Checked checked{check_extrinsics(state, frame, fit, rejection, moment, rematch)};
  if (checked.rejection != Rejection::none) {
    // A plane through wrong matches would mislead the next frame; ground that lies elsewhere does not become more
    // plausible by lasting.
    const bool lies_elsewhere{checked.rejection == Rejection::plane_contradicted ||
                              checked.rejection == Rejection::falls_away};
    if (config_.ground.estimate)
      state.plane = lies_elsewhere && state.has_been_measured ? before.previous : before.expected;
    state.plane.estimated = false;
  }
  state.has_been_measured = state.has_been_measured || state.plane.estimated;
  Verdict verdict{checked.rejection, checked.rematched_on.value_or(state.plane), checked.disagreeing};
  verdict.plane.estimated = state.plane.estimated;
  return verdict;
}

}  // namespace stereogrid
