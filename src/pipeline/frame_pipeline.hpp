// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "ground/ground_estimator.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "pipeline/frame_state.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {

/// A frame through all stages, on any back end. What crosses frames is in its FrameState and in the filter's state;
/// what a stage of process() reads is what an earlier one has returned.
class FramePipeline {
 public:
  /// `turned_rad`: pitch of the camera beyond that of `level_rig`, whose images have been levelled. `extrinsics_given`:
  /// see PipelineOptions. `cpu` must outlive the pipeline.
  FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                double turned_rad = 0, bool extrinsics_given = true);

  /// Processes one frame. `result` keeps status and warnings that it has.
  void process(const LevelFrame& frame, FrameResult& result);
  /// Makes the next frame a first one. Ids of obstacles continue.
  void reset() { state_.reset(rig_, estimator_); }
  /// Continues the ids of obstacles of `before`.
  void continue_ids(const FramePipeline& before) { state_.tracker.continue_ids(before.state_.tracker); }

  /// Plane that replaces assumed extrinsics: the next frame needs a pipeline for a rig with them.
  [[nodiscard]] std::optional<Ground> estimated_extrinsics() const { return state_.ground.extrinsics.found(); }

  /// State between two frames: saved or loaded.
  template <class State>
  void exchange(State& state) {
    state(state_);
    stages_->exchange(&state);
  }
  [[nodiscard]] MemoryUse memory_use() const;

 private:
  struct FoundGround {
    GroundFit ground;
    bool is_aligned;  ///< the vertical misalignment has been measured
  };

  [[nodiscard]] FrameGrids grids_of(const LevelFrame& frame) const;
  void match(const LevelFrame& frame, const FrameGrids& grids, const MatchGround& ground);
  [[nodiscard]] MatchedFrame matched(const LevelFrame& frame) const;
  [[nodiscard]] FlowFrame flow_frame(const LevelFrame& frame) const;
  std::span<const VelocityEvidence> track_features(const LevelFrame& frame, const GridGeometry& window, double& ms);
  bool align(const LevelFrame& frame, const Ground& expected);
  FoundGround find_ground(const LevelFrame& frame, const GroundBefore& before, const FrameMoment& moment,
                          const GroundEstimator::Rematch& rematch);
  TerrainRules find_terrain(const LevelFrame& frame, const FrameGrids& grids, const GroundFit& ground, double& ms,
                            FrameResult& result);
  [[nodiscard]] float blur_in(const LevelFrame& frame) const;
  Rejection check(const LevelFrame& frame, const GroundFit& ground, double& segments_ms);
  void publish(const LevelFrame& frame, const Verdict& verdict, FrameResult& result);
  void add_features(const LevelFrame& frame, bool is_usable, double& ms);
  const HeldObstacles& update_tracks(const LevelFrame& frame, bool is_usable, FrameResult& result, double& ms);

  Config config_;
  Rig rig_;
  double turned_rad_;
  Cpu& cpu_;
  std::unique_ptr<Stages> stages_;
  Window window_;
  GroundEstimator estimator_;
  FrameState state_;

  // working memory
  EvidenceMap velocity_evidence_;
  ClusterSpace clusters_;
};

}  // namespace stereogrid
