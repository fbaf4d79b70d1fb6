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

/// How samples bear a plane out. Only those count where it expects 1.5 px and more.
struct RoadSupport {
  int all{0};
  int near{0};            ///< within a px of it
  int below{0};           ///< clearly below it, where nothing can be
  double depth_ratio{1};  ///< of the near ones: the 90th percentile of the expected disparity to the 10th
  int columns{0};         ///< eighths of the image's width that hold near ones
  int nearest_all{0};     ///< in the lowest rows: up to 1.7 times as far as the nearest ground in view
  int nearest{0};         ///< of these, within a px of it

  /// Enough of them lie on it, few below it, over a range of depths and across the image. A wall, of one depth, is
  /// none.
  [[nodiscard]] bool is_road() const;
  /// One frame determines the extrinsics: most samples, and nearly all of the lowest rows, lie on it, over a wide range
  /// of depths and across the image. A slope or a lower floor ahead does not reach the lowest rows.
  [[nodiscard]] bool is_certain() const;
};
RoadSupport support_of(const Rig& rig, const std::vector<GroundSample>& samples, const RoadPlane& plane);

/// The road plane through `samples`, disparities of either hypothesis in the order of their rows, wherever a camera can
/// be mounted: 0.2 to 4 m above the road, pitched by −10° to 35°, rolled by up to 10°. None: nothing there looks like a
/// road. The same samples give the same plane. `turned_rad`: by how much the camera looks down more than the images do
/// that `rig` is of (they may have been levelled).
std::optional<Ground> search_mounting(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples);

/// The plane close to `start`, under the same conditions.
std::optional<Ground> refine_mounting(const Rig& rig, double turned_rad, const std::vector<GroundSample>& samples,
                                      const Ground& start);

/// `ground` as another camera at the same place sees it that looks down by `angle_rad` more.
Ground seen_from(const Ground& ground, double angle_rad);

/// Search for the camera's extrinsics in the frames. Given extrinsics are never replaced. Assumed ones are replaced by
/// what the first frames agree on. Once they have explained the ground, they are replaced only by a plane that explains
/// all that they did, the nearest ground included, while the vehicle travels: a slope, stairs or a lower floor does
/// not.
class MountingSearch {
 public:
  /// `turned_rad`: see search_mounting.
  MountingSearch(const Rig& level_rig, const GroundConfig& config, double turned_rad, bool is_given);

  /// True: look() has to see this frame. Until a few frames have shown that the extrinsics fit: always. Later: where
  /// the ground is lost; of extrinsics that can be replaced, after a second.
  bool is_wanted(bool is_lost, double dt_s);
  /// The plane in a frame that was matched on `used`; none: no plane, or `used` may stay. Where `used` is not doubted,
  /// another plane must lie outside the gates and have clearly more samples.
  std::optional<Ground> look(const std::vector<GroundSample>& samples, const Ground& used, bool is_doubted);
  /// True: `candidate` may replace the extrinsics if verify() confirms it. `place`: of the vehicle, in the world.
  bool may_replace(const std::vector<GroundSample>& samples, const Ground& used, const Ground& candidate, Point2 place);
  /// Takes that frame, matched again on the `candidate`. True: it confirms it. A first frame that determines the plane
  /// alone is enough for found().
  bool verify(const std::vector<GroundSample>& samples, const Ground& candidate);
  /// As the camera of the level rig sees it, once enough frames agree.
  [[nodiscard]] std::optional<Ground> found() const;
  /// The next frame is a first one. Extrinsics that have explained the ground keep that.
  void begin_again();

  template <class State>
  void exchange(State& state) {
    state(fitting_, agreeing_, is_certain_, sum_, lost_s_, is_better_, better_, better_from_);
  }

 private:
  [[nodiscard]] bool is_established() const;

  Rig rig_;
  GroundConfig config_;
  double turned_rad_;
  bool is_given_;
  int fitting_{0};          ///< frames that have shown that the extrinsics fit
  int agreeing_{0};         ///< frames that have shown another plane
  bool is_certain_{false};  ///< the first of them determines it
  Ground sum_{0, 0, 0};
  double lost_s_{0};
  bool is_better_{false};  ///< `better_` explains all that the extrinsics did, since the vehicle was at `better_from_`
  Ground better_{0, 0, 0};
  Point2 better_from_;
};

}  // namespace stereogrid
