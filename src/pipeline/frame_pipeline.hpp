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
  /// `turned_rad`: pitch of the camera beyond that of `level_rig`, whose images have been levelled. `mode`: origin of
  /// the extrinsics of `level_rig`. `cpu` must outlive the pipeline.
  FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                double turned_rad = 0, GroundMode mode = GroundMode::given);

  /// Processes one frame. `result` keeps status and warnings that it has. Returns extrinsics that replace the rig's:
  /// this frame needs a pipeline for a rig with them.
  std::optional<Ground> process(const LevelFrame& frame, FrameResult& result);
  /// Makes the next frame a first one. Ids of obstacles continue.
  void reset() { state_.reset(rig_, first_ground_); }
  /// Continues the ids of obstacles of `before`, and what it has found of the vehicle itself.
  void continue_from(const FramePipeline& before);

  /// State between two frames: saved or loaded.
  template <class State>
  void exchange(State& state) {
    state(state_);
    stages_->exchange(&state);
  }
  [[nodiscard]] MemoryUse memory_use() const;

 private:
  [[nodiscard]] FrameGrids grids_of(const LevelFrame& frame) const;
  [[nodiscard]] MatchedFrame matched(const LevelFrame& frame) const;
  [[nodiscard]] FlowFrame flow_frame(const LevelFrame& frame) const;
  std::span<const VelocityEvidence> track_features(const LevelFrame& frame, const GridGeometry& window, double& ms);
  bool align(const LevelFrame& frame, const Ground& expected);
  void align_first(const LevelFrame& frame, const FrameGrids& grids, const Ground& expected);
  bool find_own_surface(const LevelFrame& frame, Point2 place);
  GroundFit fit_ground(const LevelFrame& frame, double& ms);
  GroundFit rematch(const LevelFrame& frame, const FrameGrids& grids, const GroundFit& ground, double& ms);
  TerrainRules find_terrain(const FrameGrids& grids, const GroundFit& ground, double& ms, FrameResult& result);
  [[nodiscard]] float blur_in(const LevelFrame& frame) const;
  Rejection check(const LevelFrame& frame, const GroundFit& ground, double& segments_ms);
  void publish(const LevelFrame& frame, const GroundFit& ground, const Rejection& rejection, FrameResult& result);
  void add_features(const LevelFrame& frame, bool is_usable, double& ms);
  const HeldObstacles& update_tracks(const LevelFrame& frame, const GroundFit& ground, bool is_usable,
                                     FrameResult& result, double& ms);

  Config config_;
  Rig rig_;
  double turned_rad_;
  Cpu& cpu_;
  std::unique_ptr<Stages> stages_;
  Window window_;
  GroundEstimator estimator_;
  GroundState first_ground_;
  FrameState state_;

  // working memory
  GroundWorkspace ground_space_;
  EvidenceMap velocity_evidence_;
  ClusterWorkspace clusters_;
};

}  // namespace stereogrid
