// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "ground/ground_estimator.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "pipeline/frame_state.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Extrinsics of the rig as a ground plane.
inline Ground extrinsics_of(const Rig& rig) {
  return {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad};
}

/// The rig with `ground` as extrinsics.
inline Rig with_extrinsics(Rig rig, const Ground& ground) {
  rig.camera_height_m = ground.height_m;
  rig.camera_pitch_rad = ground.pitch_rad;
  rig.camera_roll_rad = ground.roll_rad;
  return rig;
}

/// Rig with the extrinsics rounded to the digits of extrinsics_message(), so that a calibration with them gives the
/// same results.
inline Rig as_written(Rig rig) {
  const auto rounded = [](double number, double steps) { return std::round(number * steps) / steps + 0.0; };
  rig.camera_height_m = rounded(rig.camera_height_m, 1e3);
  rig.camera_pitch_rad = rounded(rig.camera_pitch_rad, 1e4);
  rig.camera_roll_rad = rounded(rig.camera_roll_rad, 1e4);
  return rig;
}

/// Message about estimated extrinsics, with the line for calibration.yaml.
inline std::string extrinsics_message(const Rig& rig) {
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "the extrinsics are estimated from the images. "
                "For calibration.yaml: mount: {camera_height_m: %.3f, camera_pitch_rad: %.4f, camera_roll_rad: %.4f}",
                rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad);
  return text.data();
}

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
  /// Replaces the pixels without disparities.
  void set_mask(PixelMask mask) { stages_->set_mask(std::move(mask)); }
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
  TerrainRules find_terrain(const LevelFrame& frame, const FrameGrids& grids, const GroundFit& ground, double& ms,
                            FrameResult& result);
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
