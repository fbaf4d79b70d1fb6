// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ground/ground.hpp"
#include "held_bytes.hpp"
#include "matching/matches.hpp"
#include "stereogrid/exposure.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// What a frame was matched in, and with what result. Of `matches` the pixels of MatchLattice are read.
struct MatchedFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;
  View<const float> disparity;  ///< given instead of the right image; empty: matched
  const Matches& matches;
  View<const std::uint8_t> masked{};  ///< PixelMask: these pixels say nothing; empty: all do
};

/// Reason to reject the matches and the road plane of a frame, and the exposure of its images.
struct Doubt {
  enum Reason { none, few_matches, identical_images, road_elsewhere, road_not_seen, falls_away };

  // NOLINTNEXTLINE(google-explicit-constructor): a reason alone is a doubt of images with equal exposures
  Doubt(Reason given = none) : reason{given} {}
  friend bool operator==(const Doubt& doubt, Reason other) { return doubt.reason == other; }

  Reason reason;
  Exposure exposure{};  ///< equal, unless the images were compared
};

/// Standard deviation of the left image's noise below the row `first_row`, in grey levels: of the second differences
/// between neighbours in a row, by their median, which texture raises a little.
double noise_of(const MatchedFrame& frame, double first_row);

/// Least difference between the pixels to the left and right of one with texture, below the row `first_row`.
double textured_from(const MatchedFrame& frame, double first_row);

/// Share of the pixels with texture below the row `first_row` that have matched; of all pixels there, where next to
/// none has texture. 1 where the image has no pixels there. Those where `road` is too near for so many `disparities`
/// could not match, and do not count. Texture is what differs clearly more than noise does, in the left image and,
/// where `right_of_left` is given, after that in the right one: saturated or dark areas there have none.
double share_of_texture_matched(const MatchedFrame& frame, double first_row, const RoadPlane& road, int disparities,
                                const GreyTransfer* right_of_left = nullptr);

/// Disparities of either hypothesis at the pixels of MatchLattice; appended.
void add_samples(const MatchedFrame& frame, std::vector<GroundSample>& samples);
/// How many there can be.
std::size_t samples_max(const Rig& level_rig);

/// Has so little of the texture below the horizon of `ground` matched that the images do not belong together? Where the
/// exposures are unequal, only texture that both images can show counts.
bool has_few_matches(const MatchedFrame& frame, const Rig& level_rig, const Ground& ground, int disparities);

/// Do the samples say that the road is not where `plane` has it? Few of those where it expects road lie on it, and
/// either many lie clearly below it, where nothing can be, or another plane holds clearly more. A wall that fills the
/// view says nothing of the road.
bool speak_against(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& plane);

/// The samples where the plane `nearest` expects at least `near_part` of the largest disparity in view, and how they
/// fit `plane`. Slopes, stairs and edges farther away do not count.
struct NearGround {
  int samples{0};
  int on_plane{0};
  double misfit_px{0};  ///< mean absolute difference, each at most 2 px

  [[nodiscard]] bool holds() const { return samples >= ground_samples_min && 10 * on_plane >= 6 * samples; }
};
NearGround near_ground(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& nearest,
                       const RoadPlane& plane, double near_part);
/// Part of the largest disparity from which on ground is the nearest: up to 1.2 times the nearest distance.
constexpr double nearest_part{0.85};

/// Width of the ground in the vehicle's path, 1 m to either side, that falls away from `plane`, m: in its columns some
/// samples above one another lie clearly below it. Ground is searched where the line of sight descends by 6° or more:
/// farther away a gentle slope looks the same (docs/method.md §4.6).
double width_falling_away(const MatchedFrame& frame, const Rig& rig, const RoadPlane& plane);

/// Decides for each frame whether its grids can be relied on. One implementation serves every back end.
class FrameTrust {
 public:
  FrameTrust(const Rig& level_rig, const GroundConfig& config, int disparities);

  /// `ground`: as this frame's stages would use it, estimated or carried over. The road is known where the calibration
  /// is trusted, where the frame does not speak against `ground`, and unless it has not been measured for too long.
  Doubt judge(const MatchedFrame& frame, const Ground& ground, double dt_s);
  /// The last frame's nearest ground lies on its plane, and GroundModel::terrain judges what is farther away.
  [[nodiscard]] bool is_near_ground_known() const { return is_near_ground_known_; }

  template <class State>
  void exchange(State& state) {
    state(unmeasured_s_);
  }
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(samples_); }

 private:
  Doubt::Reason reason_to_reject(const MatchedFrame& frame, const Ground& ground, double dt_s);

  Rig rig_;
  GroundConfig config_;
  int disparities_;
  bool is_near_ground_known_{false};
  double unmeasured_s_{0};  ///< since the road was measured, or since the start
  std::vector<GroundSample> samples_;
};

/// Adds the flags and warnings of the doubt to the result.
void tell(const Doubt& doubt, FrameResult& result);

/// Adds extrinsics_disagree with a warning: the extrinsics of `level_rig`, which stay, and the plane that contradicts
/// them. `turned_rad`: see MountingSearch.
void tell_disagreement(const Rig& level_rig, double turned_rad, const Ground& plane, FrameResult& result);

/// What depends on the road, where it is not known: nothing could be seen in any bin, occupancy is 0.5. The disparity
/// images stay.
void leave_unknown(StageImages& stages);

}  // namespace stereogrid
