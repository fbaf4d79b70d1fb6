// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/matches.hpp"
#include "ground/ground.hpp"
#include "held_bytes.hpp"
#include "stereogrid/exposure.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Images of a frame and its last matches. Only the pixels of MatchLattice in `matches` are read.
struct MatchedFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;  ///< may be empty with external disparities
  const Matches& matches;
  View<const std::uint8_t> masked{};  ///< PixelMask: excluded pixels; empty: none
  bool is_external{false};            ///< the matches are external disparities
  View<const float> obstacle{};       ///< disparities of all pixels, (H, W) px, 0 = none
  View<const float> road{};
  PlaneFit fit{};  ///< through the matches on the expected plane
};

/// Reason to reject the matches and the road plane of a frame, and the exposure of its images.
struct Rejection {
  enum Reason { none, few_matches, identical_images, plane_contradicted, road_not_seen, falls_away };

  // NOLINTNEXTLINE(google-explicit-constructor): a reason alone has equal exposures
  Rejection(Reason given = none) : reason{given} {}
  friend bool operator==(const Rejection& rejection, Reason other) { return rejection.reason == other; }

  Reason reason;
  Exposure exposure{};  ///< equal, unless the images were compared
};

/// Standard deviation of the left image's noise below the row `first_row`, in grey levels. Source: the median of second
/// differences between neighbours in a row, which texture raises a little.
double noise_of(const MatchedFrame& frame, double first_row);

/// Minimum difference between both neighbours of a pixel with texture, below the row `first_row`, in grey levels.
double textured_from(const MatchedFrame& frame, double first_row);

/// Share of the pixels with texture below the row `first_row` that have matched. The share of all pixels if next to
/// none has texture; 1 if there are no pixels. Pixels where `road` has a disparity of `disparities` or more cannot
/// match and are excluded. Texture is a difference clearly above noise in the left image. With `right_of_left` it must
/// remain in the right image: saturated and dark areas there have none.
double share_of_texture_matched(const MatchedFrame& frame, double first_row, const RoadPlane& road, int disparities,
                                const GreyTransfer* right_of_left = nullptr);

/// Disparities of either hypothesis at the pixels of MatchLattice; appended.
void add_samples(const MatchedFrame& frame, std::vector<GroundSample>& samples);
std::size_t samples_max(const Rig& level_rig);

/// True where too little of the texture below the horizon of `ground` has matched for a valid pair. Where the exposures
/// are unequal, only texture visible in both images counts.
bool has_few_matches(const MatchedFrame& frame, const Rig& level_rig, const Ground& ground, int disparities);

/// True where the samples contradict `plane`: few samples in its area lie on it, and either many lie clearly below it
/// or another plane has clearly more. A wall that fills the view does not contradict it.
bool contradict(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& plane);

/// Fit to `plane` of the samples where the plane `nearest` has at least `near_part` of its largest disparity in view.
/// Slopes, stairs and edges farther away do not count.
struct NearGround {
  int samples{0};
  int on_plane{0};
  double misfit_px{0};  ///< mean absolute difference, each at most 2 px

  [[nodiscard]] bool holds() const { return samples >= ground_samples_min && 10 * on_plane >= 6 * samples; }
};
NearGround near_ground(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& nearest,
                       const RoadPlane& plane, double near_part);
/// Minimum part of the largest disparity for the nearest ground: up to 1.2 times the nearest distance.
constexpr double nearest_part{0.85};

/// Width of the ground that falls away from `plane` in the vehicle's path (1 m to either side), m. In its columns some
/// samples above one another lie clearly below the plane. Ground is searched where the line of sight descends by 6° or
/// more: farther away a gentle slope gives the same samples (docs/method.md §4.6).
double width_falling_away(const MatchedFrame& frame, const Rig& rig, const RoadPlane& plane);

/// Validates the matches and the road plane of each frame. One implementation serves every back end.
class FrameValidator {
 public:
  FrameValidator(const Rig& level_rig, const GroundConfig& config, int disparities);

  /// `ground`: plane for this frame's stages, estimated or predicted. It is rejected if the frame contradicts it, or if
  /// the road has not been measured for too long; never if nothing is to be estimated.
  Rejection validate(const MatchedFrame& frame, const Ground& ground, double dt_s);
  /// True: the last frame's nearest ground lies on its plane, and GroundModel::terrain classifies the ground farther
  /// away.
  [[nodiscard]] bool is_near_ground_known() const { return is_near_ground_known_; }

  template <class State>
  void exchange(State& state) {
    state(unmeasured_s_);
  }
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(samples_); }

 private:
  Rejection::Reason reason_to_reject(const MatchedFrame& frame, const Ground& ground, double dt_s);

  Rig rig_;
  GroundConfig config_;
  int disparities_;
  bool is_near_ground_known_{false};
  double unmeasured_s_{0};  ///< since the road was measured, or since the start
  std::vector<GroundSample> samples_;
};

/// Adds the flags and warnings of the rejection to the result.
void report(const Rejection& rejection, FrameResult& result);

/// Adds extrinsics_disagree with a warning: the extrinsics of `level_rig`, which stay, and the plane that contradicts
/// them. `turned_rad`: see ExtrinsicsSearch.
void report_disagreement(const Rig& level_rig, double turned_rad, const Ground& plane, FrameResult& result);

/// Sets the stages that depend on the road to unknown: no bin is visible, occupancy is 0.5. The disparity images stay.
void set_unknown(StageImages& stages);

}  // namespace stereogrid
