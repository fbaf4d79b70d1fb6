// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "ground/extrinsics_search.hpp"
#include "ground/frame_validator.hpp"
#include "ground/ground.hpp"
#include "held_bytes.hpp"
#include "stereogrid/config.hpp"

namespace stereogrid {

/// State of the ground between two frames.
struct GroundState {
  Ground plane;                   ///< ground of the last frame
  bool has_been_measured{false};  ///< in any frame
  int frames_to_search{0};        ///< pause between two searches for a lost plane
  FrameValidator validator;
  ExtrinsicsSearch extrinsics;

  template <class State>
  void exchange(State& state) {
    state(plane, frames_to_search, has_been_measured, validator, extrinsics);
  }
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(validator); }
};

/// Ground of a frame.
struct GroundFit {
  Ground plane;
  std::optional<Ground> slope{};  ///< slope that fills the view, relief over the plane; the frame is matched on it

  /// Plane of the disparity images.
  [[nodiscard]] const Ground& matched_on() const { return slope ? *slope : plane; }
};

/// Result of the checks of a frame.
struct Verdict {
  Rejection rejection;
  Ground plane;                         ///< plane of the disparity images
  std::optional<Ground> disagreeing{};  ///< plane in view that contradicts extrinsics that stay

  [[nodiscard]] bool is_usable() const { return rejection == Rejection::none; }
};

/// Planes of a frame before its own is measured.
struct GroundBefore {
  Ground previous;  ///< ground of the frame before
  Ground expected;  ///< predicted from it
};

/// Place and time of a frame.
struct FrameMoment {
  Point2 place;  ///< place of the vehicle in the world, m
  double dt_s;   ///< since the frame before
};

/// Owner of the ground: finds the plane of each frame, checks it, and alone has the frame matched again. State between
/// frames is in GroundState. One implementation serves every back end.
class GroundEstimator {
 public:
  /// Matches the frame on another plane, with a fit (with the state's plane as previous one) if that is wanted. The
  /// MatchedFrame shows the new matches from then on.
  using Rematch = std::function<PlaneFit(const Ground& plane, bool wants_fit)>;

  /// `turned_rad`: pitch of the camera beyond that of `level_rig`; `extrinsics_given`: see PipelineOptions.
  GroundEstimator(const Rig& level_rig, const Config& config, double turned_rad, bool extrinsics_given);

  [[nodiscard]] GroundState initial() const;
  /// Makes the next frame a first one. Confirmed extrinsics remain confirmed.
  void restart(GroundState& state) const;
  [[nodiscard]] Ground expected(const GroundState& state, double dt_s) const;

  /// True: the plane is searched in all matches: in the first frame, and where the ground is lost. A search that has
  /// failed is not repeated for some frames.
  bool wants_search(GroundState& state, bool is_first, const PlaneFit& fit) const;
  /// Ground of a frame that has been matched on the expected plane. `searches`: result of wants_search().
  GroundFit fit(GroundState& state, const MatchedFrame& frame, const Ground& expected, bool searches, Point2 place,
                const Rematch& rematch);
  /// Takes the plane into the state, and validates the frame.
  Rejection validate(GroundState& state, const MatchedFrame& frame, const GroundFit& fit, double dt_s) const;
  /// Final verdict, after a check of the extrinsics, and the state for the next frame.
  Verdict settle(GroundState& state, const MatchedFrame& frame, const GroundFit& fit, const Rejection& rejection,
                 const GroundBefore& before, const FrameMoment& moment, const Rematch& rematch);

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(space_, samples_); }

 private:
  PlaneFit search(GroundState& state, const MatchedFrame& frame, const PlaneFit& fit, const Rematch& rematch);
  [[nodiscard]] bool is_jump(const GroundState& state, const Ground& found) const;
  Ground keep_near_ground(const MatchedFrame& frame, const Ground& expected, const Ground& estimated, bool has_searched,
                          const Rematch& rematch);
  std::optional<Ground> find_slope(GroundState& state, const Ground& used, Point2 place, const Rematch& rematch);
  /// Result of the check of the extrinsics.
  struct Checked {
    Rejection rejection;
    std::optional<Ground> disagreeing{};
    std::optional<Ground> rematched_on{};
  };
  Checked check_extrinsics(GroundState& state, const MatchedFrame& frame, const GroundFit& fit,
                           const Rejection& rejection, const FrameMoment& moment, const Rematch& rematch);
  void sample(const MatchedFrame& frame);

  Rig rig_;
  Config config_;
  double turned_rad_;
  bool has_given_extrinsics_;
  GroundSpace space_;
  std::vector<GroundSample> samples_;
};

}  // namespace stereogrid
