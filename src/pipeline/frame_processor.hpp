// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "filter/filter.hpp"
#include "ground/ground.hpp"
#include "ground/mounting_search.hpp"
#include "ground/trust.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "motion/scene_flow.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/near_obstacles.hpp"
#include "obstacles/tracking.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {

/// The way of a frame through all stages, whichever back end does them, and what the host decides on the way: whether
/// the road is lost and where it is, by how much rows are off, whether the frame can be relied on, what moves.
class FrameProcessor {
 public:
  /// `turned_rad`: by how much the camera looks down more than the images of `level_rig`, which have been levelled.
  /// `has_given_extrinsics`: PipelineOptions::extrinsics_given.
  FrameProcessor(const Config& config, const Rig& level_rig, std::unique_ptr<Stages> stages, double turned_rad = 0,
                 bool has_given_extrinsics = true);

  /// Pixels that show the vehicle, for all frames. Before the first one.
  void take_mask(PixelMask mask);
  /// Begins a frame: the back end is given what it can do without the host. `result` and what `frame` views must stay
  /// until finish().
  void start(const LevelFrame& frame, FrameResult& result);
  /// What is called, if there is a device, when something can be done of the frame behind.
  struct Ahead {
    std::function<void()> images_free{};  ///< this frame's images are no longer needed
    std::function<void()> device_free{};  ///< start() may be called: only the host is still busy with this frame
  };
  /// All the rest of a frame that has been started.
  void finish(const LevelFrame& frame, FrameResult& result, const Ahead& ahead);
  /// The next frame is a first one. Ids of obstacles go on.
  void forget();
  /// Ids of obstacles go on from those of `before`, everything else begins.
  void follow_on(const FrameProcessor& before);

  /// Where the level rig's camera turned out to be mounted, if the rig says otherwise: a processor for the right rig
  /// has to go on.
  [[nodiscard]] std::optional<Ground> found_mounting() const { return mounting_.found(); }

  /// What is remembered between two frames.
  void save(StateWriter& state);
  void load(StateReader& state);
  [[nodiscard]] MemoryUse memory_use() const;
  [[nodiscard]] Stages& stages() { return *stages_; }
  [[nodiscard]] const Stages& stages() const { return *stages_; }

 private:
  template <class First, class Second>
  void together(const First& first, const Second& second);
  void match(const Ground& expected, bool estimates_ground = true);
  void make_grids();
  void follow_points(const LevelFrame& frame, const GridGeometry& window);
  void add_points(const LevelFrame& frame);
  void measure_rows(const LevelFrame& frame);
  double find_grids(const LevelFrame& frame, FrameResult& result);
  double find_grids_and_segments(const LevelFrame& frame, FrameResult& result);
  void find_road(const LevelFrame& frame, bool searches);
  bool will_search();
  bool search(const LevelFrame& frame);
  [[nodiscard]] bool is_jump(const Ground& found) const;
  Doubt judge(const LevelFrame& frame);
  bool accept(const LevelFrame& frame, Doubt doubt, FrameResult& result);
  void find_segments(const LevelFrame& frame);
  void compare_near(const LevelFrame& frame);
  Doubt look_at_mounting(const LevelFrame& frame, Doubt doubt);
  [[nodiscard]] MatchedFrame matched(const LevelFrame& frame) const;
  void track(const LevelFrame& frame, FrameResult& result);

  [[nodiscard]] FlowFrame flow_frame(const LevelFrame& frame) const;
  [[nodiscard]] bool flows(const LevelFrame& frame) const { return config_.filter.scene_flow && !frame.is_given(); }
  template <class State>
  void exchange(State& state);

  Config config_;
  Rig rig_;
  double turned_rad_;
  bool has_given_extrinsics_;
  PixelMask mask_;
  std::unique_ptr<Stages> stages_;
  Window window_;

  // between frames
  Ground ground_;
  FrameTrust trust_;
  MountingSearch mounting_;
  int frames_to_search_{0};
  bool is_first_{true};
  bool has_measured_ground_{false};
  RowAlignment alignment_;
  SceneFlow scene_flow_;
  Tracker tracker_;
  NearObstacles near_;

  // of a frame
  Ground ground_before_;               ///< of the frame before
  Ground expected_;                    ///< before it is measured
  std::optional<Ground> disagreeing_;  ///< ground plane in view that contradicts extrinsics that stay
  bool is_reliable_{true};             ///< may the grids be built on its matches?
  bool has_segments_{false};           ///< its segments have been found
  GroundSpace ground_samples_;
  std::vector<GroundSample> mounting_samples_;
  EvidenceMap velocity_evidence_;
  ClusterSpace clusters_;
};

}  // namespace stereogrid
