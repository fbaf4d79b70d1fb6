// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/matches.hpp"
#include "ground/plane_evidence.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/exposure.hpp"
#include "stereogrid/result.hpp"

namespace stereogrid {

/// Images of a frame and its last matches. Only the pixels of MatchLattice in `matches` are read.
struct MatchedFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;  ///< may be empty with external disparities
  const Matches& matches;
  View<const std::uint8_t> masked{};  ///< PixelMask: excluded pixels; empty: none
  View<const float> external{};       ///< external disparities, which the matches are then; empty: none

  [[nodiscard]] bool is_external() const { return !external.empty(); }
};

/// Reason to reject the matches and the road plane of a frame, and the exposure of its images.
struct Rejection {
  enum Reason {
    none,
    few_matches,
    identical_images,
    no_disparities,
    plane_contradicted,
    ground_not_found,
    camera_rolled,
    road_not_seen,
    falls_away
  };

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

/// True where too little of the texture below the horizon of `ground` has matched for a valid pair. Where the exposures
/// are unequal, only texture visible in both images counts. External disparities may be sparse: true where there are
/// none.
bool has_few_matches(const MatchedFrame& frame, const Rig& level_rig, const Ground& ground, int disparities);

/// Width of the ground that falls away from `plane` in the vehicle's path (1 m to either side), m. In its columns some
/// samples above one another lie clearly below the plane. Ground is searched where the line of sight descends by 6° or
/// more: farther away a gentle slope gives the same samples (docs/method.md §4.6).
double width_falling_away(const MatchedFrame& frame, const Rig& rig, const RoadPlane& plane);
/// True: more of it than reflections and repeated texture give.
inline bool falls_away(const MatchedFrame& frame, const Rig& rig, const Ground& ground) {
  constexpr double falling_max_m{0.5};
  return width_falling_away(frame, rig, road_plane(rig, ground)) > falling_max_m;
}

/// True: the rejection is not one of the images, so that the frame's plane may be used.
inline bool has_matched(const Rejection& rejection) {
  return !(rejection == Rejection::few_matches || rejection == Rejection::identical_images ||
           rejection == Rejection::no_disparities);
}

/// Checks the images of a frame: whether they match as those of a valid pair do, and their exposures. `plane`: of the
/// disparity images.
Rejection check_images(const MatchedFrame& frame, const Rig& level_rig, const Ground& plane, int disparities);

/// Adds the flags and warnings of the rejection to the result.
void report(const Rejection& rejection, FrameResult& result);

/// Adds extrinsics_disagree with a warning: the extrinsics of `level_rig`, which stay, and the plane that contradicts
/// them. `turned_rad`: see GroundEstimator.
void report_disagreement(const Rig& level_rig, double turned_rad, const Ground& plane, FrameResult& result);

/// Adds road_unknown with a warning for Rejection::camera_rolled. `seen`: ground that is in view.
void report_roll(const Ground& seen, FrameResult& result);

/// Sets the stages that depend on the road to unknown: no bin is visible, occupancy is 0.5. The disparity images stay.
void set_unknown(StageImages& stages);

}  // namespace stereogrid
