// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "ground/frame_validator.hpp"
#include "ground/plane_search.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Origin of the extrinsics (height, pitch and roll of the camera over its ground).
enum class GroundMode : std::uint8_t {
  assumed,  ///< none given and none found: no plane is used
  found,    ///< estimated from frames; replaced only by GroundEstimator's two rules
  given,    ///< from the calibration: never replaced
};

/// Ground between two frames. Planes are relative to the level rig's camera.
struct GroundState {
  GroundMode mode{GroundMode::given};
  Ground extrinsics;                ///< values in use, with their uncertainty: change slowly
  Ground plane;                     ///< last frame's ground; `estimated`: it was measured
  std::optional<Ground> given;      ///< extrinsics of the calibration
  std::optional<Ground> candidate;  ///< `assumed`: plane that frames have weakly supported; mean of them
  int candidate_frames{0};          ///< number of these frames
  int agreeing{0};                  ///< frames that have confirmed the extrinsics, at most agreeing_min
  double unmeasured_s{0};           ///< time since the ground was measured
  std::optional<Ground> better;     ///< `found`: plane that explains the nearest ground since `better_from`
  Point2 better_from;               ///< position of the vehicle in the world frame, m
  bool on_slope{false};             ///< a slope fills the view, since `slope_from`
  Point2 slope_from;                ///< position of the vehicle in the world frame, m

  template <class State>
  void exchange(State& state) {
    state(mode, extrinsics, plane, given, candidate, candidate_frames, agreeing, unmeasured_s, better, better_from,
          on_slope, slope_from);
  }
};

/// Frames that must confirm found extrinsics before only travel can replace them.
constexpr int agreeing_min{3};

/// State before the first frame with these extrinsics. Their standard deviations are those of a measurement by hand.
GroundState first_ground(const Ground& extrinsics, GroundMode mode);

/// Ground plane of a frame, relative to the level rig's camera.
struct GroundFit {
  Ground plane;                       ///< `estimated`: measured in this frame; else the extrinsics
  bool is_sound{false};               ///< `assumed`: the plane is known from this frame alone
  bool is_candidate{false};           ///< `assumed`: frames that agree on it determine the plane
  std::optional<Ground> rolled;       ///< `assumed`: the view is that of a camera rolled by more than a search covers
  bool is_contradicted{false};        ///< the plane is not in view, and the view contradicts it
  PlaneSupport support;               ///< evidence of `plane`
  std::optional<Ground> disagreeing;  ///< sound plane with clearly more evidence, and no slope; extrinsics stay
  std::optional<Ground> slope;        ///< sound plane that meets that of the extrinsics ahead: relief
  std::optional<Ground> replacement;  ///< `found`: plane that explains the nearest ground better
  bool replaces_at_once{false};       ///< the extrinsics have not been confirmed yet
  bool wants_rematch{false};          ///< over 3 px from the plane that the frame was matched on

  /// Plane to match the frame on.
  [[nodiscard]] const Ground& matched_on() const { return slope ? *slope : plane; }
};

/// Result of GroundEstimator::settle().
struct SettledGround {
  GroundState state;
  std::optional<Ground> new_extrinsics;  ///< `state` is for a rig with them, and not for the level rig in use
};

/// Buffers of GroundEstimator, for one frame at a time.
struct GroundWorkspace {
  explicit GroundWorkspace(const Rig& level_rig);
  [[nodiscard]] std::size_t memory_bytes() const { return memory_bytes_of(blocks, samples, search); }

  std::vector<float> blocks;
  PlaneSamples samples;
  PlaneSearchWorkspace search;
};

/// Owner of the ground plane: search, fit, checks and the next state, as functions of values. Evidence of planes by
/// visibility: docs/method.md §4.5.
class GroundEstimator {
 public:
  /// `turned_rad`: pitch of the camera relative to the levelled images of `level_rig`, positive downwards.
  GroundEstimator(const Rig& level_rig, const Config& config, double turned_rad);

  /// Plane of a frame `dt_s` after the state, for the road hypothesis of the matcher. `assumed`: a plane that is not in
  /// view, so that every pixel is matched as upright.
  [[nodiscard]] Ground expected(const GroundState& state, double dt_s) const;

  /// Reads the samples of a frame above the row `own_from_row` into `space`, for fit() and refit().
  void gather(const MatchedFrame& frame, int own_from_row, GroundWorkspace& space) const;
  /// Ground of a frame that was matched on expected(). A search where the ground is unknown or not in view.
  [[nodiscard]] GroundFit fit(const GroundState& state, double dt_s, GroundWorkspace& space) const;
  /// Ground of a frame that was matched again on `before`, the first fit's plane: no search.
  [[nodiscard]] GroundFit refit(const GroundState& state, const GroundFit& before, GroundWorkspace& space) const;

  /// Reason to reject the frame's plane; the images are not checked.
  [[nodiscard]] Rejection::Reason reason_to_reject(const GroundState& state, const GroundFit& fit, double dt_s) const;

  /// State after a frame; the only function that changes it. `is_usable` false: the frame was rejected for its images,
  /// and its plane is not used. `place`: position of the vehicle in the world frame, m.
  [[nodiscard]] SettledGround settle(const GroundState& state, const GroundFit& fit, bool is_usable, double dt_s,
                                     Point2 place) const;

 private:
  void collect(const MatchedFrame& frame, int own_from_row, PlaneSamples& samples) const;
  [[nodiscard]] GroundFit searched(GroundWorkspace& space) const;
  [[nodiscard]] std::optional<Ground> rolled(double upright_nats, GroundWorkspace& space) const;
  [[nodiscard]] std::optional<Ground> measured(const Ground& expected, const PlaneSamples& samples,
                                               PlaneSupport& support) const;
  [[nodiscard]] GroundFit tracked(const GroundState& state, const Ground& expected, const PlaneSamples& samples) const;
  void compare(const GroundState& state, GroundWorkspace& space, GroundFit& fit) const;
  [[nodiscard]] std::size_t best_of(const PlaneSamples& samples, const std::vector<FittedPlane>& planes) const;
  [[nodiscard]] bool has_margin(const PlaneSamples& samples, const std::vector<FittedPlane>& planes,
                                std::size_t best) const;
  [[nodiscard]] bool is_within_gates(const Ground& extrinsics, const Ground& plane) const;
  [[nodiscard]] bool is_slope_ahead(const Ground& extrinsics, const Ground& seen) const;
  [[nodiscard]] bool is_far_from(const Ground& before, const Ground& plane, const PlaneSamples& samples) const;

  Rig rig_;
  GroundConfig config_;
  int disparities_;
  double step_m_;
  double turned_rad_;
};

}  // namespace stereogrid
