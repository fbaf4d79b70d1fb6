// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "ground/ground.hpp"
#include "held_bytes.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Support of a plane by samples, at pixels where it expects 1.5 px and more.
struct RoadSupport {
  int all{0};             ///< number of samples
  int near{0};            ///< samples within 1 px of the plane
  int below{0};           ///< samples clearly below the plane
  double depth_ratio{1};  ///< 90th percentile of the near samples' expected disparity, relative to the 10th
  int columns{0};         ///< eighths of the image's width with near samples
  int nearest_all{0};     ///< samples up to 1.7 times the distance of the nearest ground in view
  int nearest{0};         ///< samples among them within 1 px of the plane

  /// True: enough samples on the plane and few below it, over a range of depths and across the image. A wall has one
  /// depth only.
  [[nodiscard]] bool is_road() const;
  /// True: one frame determines the extrinsics. Most samples, and nearly all of the nearest ones, lie on the plane,
  /// over a wide range of depths and across the image. A slope or a lower floor ahead has no samples as near.
  [[nodiscard]] bool is_certain() const;
};
RoadSupport support_of(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& plane);

/// Road plane through `samples` (disparities of either hypothesis, in the order of their rows), 0.2 to 4 m below the
/// camera, pitch −10° to 35°, roll up to 10°. Empty: no road found. The same samples give the same plane. `turned_rad`:
/// pitch of the camera relative to the levelled images of `rig`, positive downwards.
std::optional<Ground> search_extrinsics(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples);

/// Road plane close to `start`, under the same conditions.
std::optional<Ground> refine_extrinsics(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples,
                                        const Ground& start);

/// `ground` relative to a camera at the same place that is pitched down by `angle_rad` more.
Ground seen_from(const Ground& ground, double angle_rad);

/// Search for the camera's extrinsics in the frames. Given extrinsics are never replaced. Assumed ones are replaced by
/// the plane on which the first frames agree. Once the extrinsics have fitted the ground, another plane must fit all
/// ground that they did, the nearest included, while the vehicle travels. A slope, stairs or a lower floor does not.
class ExtrinsicsSearch {
 public:
  /// `turned_rad`: see search_extrinsics.
  ExtrinsicsSearch(const Rig& level_rig, const GroundConfig& config, double turned_rad, bool is_given);

  /// True: look() needs this frame. Until a few frames have confirmed the extrinsics: always. Later: where the ground
  /// is lost; for extrinsics that can be replaced, after 1 s of it.
  bool is_wanted(bool is_lost, double dt_s);
  /// Plane in a frame that was matched on `used`. Empty: no plane, or `used` remains valid. If the frame does not
  /// contradict `used`, another plane must lie outside the gates and have clearly more samples.
  std::optional<Ground> look(const std::vector<GroundSample>& samples, const Ground& used, bool is_rejected);
  /// Slope that fills the view: its plane meets that of the given extrinsics between the vehicle and the nearest
  /// visible ground. Empty: none, or another cause. A camera that was turned sees the road meet that plane below
  /// itself; one that was moved otherwise sees a slope that does not end within ten of its heights. `place`: see
  /// may_replace().
  std::optional<Ground> find_slope(const std::vector<GroundSample>& samples, Point2 place);
  /// The nearest ground fits: no slope fills the view.
  void leave_slope() { is_on_slope_ = false; }
  /// True: `candidate` may replace the extrinsics if verify() confirms it. `place`: vehicle position
  /// in the world frame, m.
  bool may_replace(const std::vector<GroundSample>& samples, const Ground& used, const Ground& candidate, Point2 place);
  /// True: the frame, matched again on `candidate`, confirms it. found() needs no other frame if the first one
  /// determines the plane alone.
  bool verify(const std::vector<GroundSample>& samples, const Ground& candidate);
  /// Plane relative to the level rig's camera, once enough frames agree.
  [[nodiscard]] std::optional<Ground> found() const;
  /// Restarts the search with the next frame. Confirmed extrinsics remain confirmed.
  void begin_again();

  template <class State>
  void exchange(State& state) {
    state(fitting_, agreeing_, is_certain_, sum_, lost_s_, is_better_, better_, better_from_, is_on_slope_,
          slope_from_);
  }

 private:
  [[nodiscard]] bool is_established() const;

  Rig rig_;
  GroundConfig config_;
  double turned_rad_;
  bool is_given_;
  int fitting_{0};          ///< frames that have confirmed the extrinsics
  int agreeing_{0};         ///< frames that have confirmed another plane
  bool is_certain_{false};  ///< the first of them determines the plane
  Ground sum_{0, 0, 0};
  double lost_s_{0};
  bool is_better_{false};  ///< `better_` has fitted all ground since `better_from_`
  Ground better_{0, 0, 0};
  Point2 better_from_;
  bool is_on_slope_{false};  ///< slopes have filled the view since `slope_from_`
  Point2 slope_from_;
};

}  // namespace stereogrid
