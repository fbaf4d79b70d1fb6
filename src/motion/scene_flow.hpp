// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/matches.hpp"
#include "images/patch.hpp"
#include "images/row_alignment/model.hpp"
#include "memory_bytes.hpp"
#include "motion/ego_error.hpp"
#include "motion/symmetric2.hpp"
#include "stereogrid/camera.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// A patch resampled for another distance, cut out of an image of its surroundings.
class ScaledPatch;

/// Input of scene flow for a frame: level images and their geometry.
struct FlowFrame {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;  ///< empty: disparities of points are those of `disparity`
  RowOffsets row_offsets;
  Pose2 world_from_vehicle;
  double dt_s;
  View<const float> disparity{};  ///< external disparities, px; ≤ 0: none
  double external_sigma_px{0};    ///< standard deviation of those
};

/// Points of obstacles followed in both images, or in the left image and external disparities, through time: where each
/// is on the ground, frame after frame, hence how it moves. It works on smoothed images: noise and the interpolation
/// between pixels pull displacements towards whole pixels. Points with positions and velocities from stereo and time
/// are "6D-Vision" (Franke et al. 2005; Rabe 2011); here a velocity is the slope of a straight line through the latest
/// positions. One implementation serves every back end: it reads some hundred patches.
class SceneFlow {
 public:
  explicit SceneFlow(const Rig& rig);

  /// Finds the points of the frame before in this one. `for_ranges(count, work)` calls work(begin, end) on parts of
  /// [0, count), on threads of its own if it likes.
  template <class ForRanges>
  void follow(const FlowFrame& frame, const ForRanges& for_ranges) {
    now_s_ += frame.dt_s;
    for_ranges(left_.height(), [&](int begin, int end) {
      smooth_rows(frame.left, begin, end, left_.view());
      if (!frame.right.empty()) smooth_rows(frame.right, begin, end, right_.view());
    });
    for_ranges(static_cast<int>(points_.size()), [&](int begin, int end) {
      for (int i{begin}; i < end; ++i) points_[static_cast<std::size_t>(i)].is_lost = !follow(i, frame);
    });
    collect(frame);
  }

  /// Takes new points where the matches of the frame followed last are obstacles and no point is yet. Reads `matches`
  /// at the pixels of MatchLattice.
  template <class ForRanges>
  void add_points(const FlowFrame& frame, const Matches& matches, const ForRanges& for_ranges) {
    mark_taken();
    for_ranges(blocks_across_ * blocks_down_, [&](int begin, int end) {
      for (int i{begin}; i < end; ++i) candidates_[static_cast<std::size_t>(i)] = candidate(i, frame, matches);
    });
    take_candidates();
  }

  /// Drops all points: the next frame has none to track.
  void clear();

  /// Vectors of the points tracked in the last follow().
  [[nodiscard]] const std::vector<FlowVector>& vectors() const { return vectors_; }
  /// Number of points reserved at construction, twice the maximum selected in an empty image. More points allocate
  /// once.
  [[nodiscard]] std::size_t points_reserved() const { return 2 * candidates_.size(); }

  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(left_before_, left_, right_, points_, vectors_, ego_error_, is_taken_, candidates_);
  }

  template <class State>
  void exchange(State& state) {
    state(now_s_, left_before_, points_, ego_error_);
  }

 private:
  /// Number of positions from which a velocity is computed.
  static constexpr int remembered{6};

  struct Sighting {
    double time_s;
    Point2 place;  ///< world
  };
  struct Point {
    Place left;
    float disparity;
    int sightings;
    std::array<Sighting, remembered> latest;  ///< the last one first
    Point2 velocity;                          ///< world, m/s
    double spread_s2;                         ///< summed squared distance of the sightings' times from their mean
    bool is_lost;

    template <class State>
    void exchange(State& state) {
      state(left, disparity, sightings, latest, velocity, spread_s2, is_lost);
    }
  };

  bool follow(int i, const FlowFrame& frame);
  void add_observation(Point& point, Place left, float disparity, Point2 place) const;
  [[nodiscard]] std::optional<Place> in_left(const Point& point, const ScaledPatch& patch, Place expected,
                                             double dt_s) const;
  [[nodiscard]] std::optional<float> disparity_of(const Point& point, const ScaledPatch& patch, Place left,
                                                  float expected, const FlowFrame& frame) const;
  [[nodiscard]] Point2 in_vehicle(Place left, double disparity) const;
  [[nodiscard]] FlowVector vector_of(const Point& point, const FlowFrame& frame) const;
  [[nodiscard]] std::optional<Point> candidate(int block, const FlowFrame& frame, const Matches& matches) const;
  [[nodiscard]] bool is_near(int v, float disparity) const;
  [[nodiscard]] std::optional<Point> point_at(Place left, const Template& patch, const FlowFrame& frame,
                                              const Matches& matches) const;
  void collect(const FlowFrame& frame);
  void mark_taken();
  void take_candidates();

  Rig rig_;
  double focal_baseline_pxm_;
  int blocks_across_;
  int blocks_down_;
  double now_s_{0};
  Image<std::uint8_t> left_before_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
  std::vector<Point> points_;
  std::vector<FlowVector> vectors_;
  EgoError ego_error_;
  std::vector<std::uint8_t> is_taken_;            ///< by block: contains a point
  std::vector<std::optional<Point>> candidates_;  ///< by block
};

}  // namespace stereogrid
