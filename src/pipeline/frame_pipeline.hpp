// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "filter/filter.hpp"
#include "ground/extrinsics_search.hpp"
#include "ground/frame_validator.hpp"
#include "ground/ground.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "motion/scene_flow.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/segmentation/near_obstacles.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "pipeline/stages.hpp"
#include "terrain/frame_terrain.hpp"

namespace stereogrid {

/// A frame through all stages, on any back end, and the decisions of the host between them: whether the ground is lost,
/// vertical misalignment, rejection of the frame, obstacles.
class FramePipeline {
 public:
  /// `turned_rad`: pitch of the camera beyond that of `level_rig`, whose images have been levelled. `extrinsics_given`:
  /// see PipelineOptions. `cpu` must outlive the pipeline.
  FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                PixelMask mask = {}, double turned_rad = 0, bool extrinsics_given = true);

  /// Processes one frame. `result` keeps status and warnings that it has.
  void process(const LevelFrame& frame, FrameResult& result);
  /// Makes the next frame a first one. Ids of obstacles continue.
  void reset();
  /// Continues the ids of obstacles of `before`.
  void continue_ids(const FramePipeline& before) { tracker_.go_on_from(before.tracker_); }

  /// Plane that replaces assumed extrinsics: the next frame needs a pipeline for a rig with them.
  [[nodiscard]] std::optional<Ground> estimated_extrinsics() const { return extrinsics_search_.found(); }

  /// State between two frames.
  void save(StateWriter& state);
  void load(StateReader& state);
  [[nodiscard]] MemoryUse memory_use() const;
  [[nodiscard]] Stages& stages() { return *stages_; }

 private:
  /// Planes of a frame before its own is measured.
  struct GroundBefore {
    Ground previous;  ///< ground of the frame before
    Ground expected;  ///< predicted from it
  };

  template <class StageCalls, class HostWork>
  void beside(const StageCalls& stage_calls, const HostWork& host_work);
  void match(const Ground& expected, bool estimates_ground = true);
  std::span<const VelocityEvidence> track_features(const LevelFrame& frame, const GridGeometry& window);
  void compare_near(const LevelFrame& frame, const Ground& expected, const GridGeometry& window);
  bool find_ground(const LevelFrame& frame, const Ground& expected);
  void keep_near_ground(const LevelFrame& frame, const Ground& expected, bool has_searched);
  void find_slope(const LevelFrame& frame);
  void find_terrain(const LevelFrame& frame, const GridGeometry& window, FrameResult& result);
  void find_blur(const LevelFrame& frame);
  void observe_and_filter(bool is_usable, std::span<const VelocityEvidence> velocities);
  void bound_filtered(const LevelFrame& frame, bool is_usable, FrameResult& result);
  Rejection validate(const LevelFrame& frame);
  void find_segments(const LevelFrame& frame);
  Rejection settle(const LevelFrame& frame, Rejection rejection, const GroundBefore& before, FrameResult& result);
  void update_tracks(const LevelFrame& frame, bool is_usable, FrameResult& result);
  void add_features(const LevelFrame& frame);

  void align(const LevelFrame& frame, const Ground& expected);
  bool will_search();
  void search();
  [[nodiscard]] bool is_jump(const Ground& found) const;
  Rejection check_extrinsics(const LevelFrame& frame, Rejection rejection);
  [[nodiscard]] MatchedFrame matched(const LevelFrame& frame) const;
  [[nodiscard]] FlowFrame flow_frame(const LevelFrame& frame) const;
  template <class State>
  void exchange(State& state);

  Config config_;
  Rig rig_;
  double turned_rad_;
  bool has_given_extrinsics_;
  Cpu& cpu_;
  PixelMask mask_;
  std::unique_ptr<Stages> stages_;
  Window window_;

  // between frames
  Ground ground_;
  FrameValidator validator_;
  ExtrinsicsSearch extrinsics_search_;
  int frames_to_search_{0};
  bool is_first_{true};
  bool has_measured_ground_{false};
  RowAlignment alignment_;
  SceneFlow scene_flow_;
  Tracker tracker_;
  NearObstacles near_;
  std::optional<FrameTerrain> terrain_;  ///< GroundModel::terrain

  // per frame
  std::optional<Ground> disagreeing_;  ///< ground plane in view that contradicts extrinsics that stay
  std::optional<Ground> candidate_;    ///< plane that a rejected frame was matched on again
  std::optional<Ground> slope_;        ///< slope that fills the view, relief over the ground
  double flow_ms_{0};
  double track_ms_{0};
  double terrain_ms_{0};
  GroundSpace ground_samples_;
  std::vector<GroundSample> extrinsics_samples_;
  EvidenceMap velocity_evidence_;
  ClusterSpace clusters_;
};

}  // namespace stereogrid
