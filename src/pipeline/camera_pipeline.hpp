// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ground/ground_estimator.hpp"
#include "obstacles/segmentation/clusters.hpp"
#include "pipeline/camera_state.hpp"
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
  std::array<char, 160> place{};
  if (camera_place(rig) != Pose2{}) {
    std::snprintf(place.data(), place.size(), ", camera_x_m: %.9g, camera_y_m: %.9g, camera_yaw_rad: %.9g",
                  rig.camera_x_m, rig.camera_y_m, rig.camera_yaw_rad);
  }
  std::snprintf(text.data(), text.size(),
                "the extrinsics are estimated from the images. "
                "For calibration.yaml: mount: {camera_height_m: %.3f, camera_pitch_rad: %.4f, camera_roll_rad: %.4f%s}",
                rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad, place.data());
  return text.data();
}

/// A camera of a FramePipeline.
struct CameraSetup {
  Config config;
  Rig level_rig;
  std::unique_ptr<Stages> stages;
  double turned_rad{0};                ///< pitch of the camera beyond that of `level_rig`, whose images are level
  GroundMode mode{GroundMode::given};  ///< origin of the extrinsics of `level_rig`
};

/// Values of a camera in one frame.
struct CameraFrame {
  const LevelFrame& frame;
  FrameGrids grids;
  FrameResult& result;  ///< result of this camera
  Ground expected{};
  GroundFit ground{};
  TerrainRules rules{};
  bool has_own_changed{false};  ///< the rows that show the vehicle have changed
  Rejection rejection{};
  SettledGround settled{};
  StageTimes times{};  ///< times of the host's own stages

  [[nodiscard]] bool is_usable() const { return rejection == Rejection::none; }
};

/// The stages of a frame that each camera has of its own, on any back end.
class CameraPipeline {
 public:
  /// `cpu` must outlive the pipeline.
  CameraPipeline(CameraSetup setup, Cpu& cpu);

  /// Begins a frame: enqueues its matching on the expected ground.
  void begin(CameraFrame& now);
  /// Matches, tracked features, ground and terrain of the frame.
  void look(CameraFrame& now);
  /// A frame in which the camera has no images.
  void look_at_nothing(const FrameGrids& grids);
  /// Occupancy of both grids by the frame (IV, V-A). False: both are unknown.
  void observe(const CameraFrame& now, bool is_usable);
  /// Checks the frame. May run beside observe().
  [[nodiscard]] Rejection check(CameraFrame& now);
  /// Waits for the ground: terrain and result have it.
  void finish_ground(CameraFrame& now);
  /// Segments of a usable frame. May run beside finish_ground() and publish().
  void find_segments(CameraFrame& now);
  /// Decides about the ground.
  void settle(CameraFrame& now, const Rejection& checked);
  /// Densities, stages, ground and conditions of the camera's result.
  void publish(const CameraFrame& now);
  /// Ends the frame's changes of the state, but for obstacles and features.
  void end(const CameraFrame& now);
  /// Clusters of a usable frame, with occupancies and velocities of `world`.
  void find_clusters(const GridLayers& world, const CameraFrame& now);
  /// Selects features to be tracked from the next frame on.
  void add_features(CameraFrame& now);

  /// Makes the next frame a first one.
  void reset() { state_.reset(rig_, first_ground_); }
  /// Continues what `before` has found of the vehicle itself.
  void continue_from(const CameraPipeline& before);
  template <class State>
  void exchange(State& state) {
    state(state_);
    stages_->exchange(&state);
  }
  [[nodiscard]] MemoryUse memory_use() const;

  [[nodiscard]] const Rig& level_rig() const { return rig_; }
  [[nodiscard]] Stages& stages() { return *stages_; }
  [[nodiscard]] std::vector<Cluster>& clusters() { return clusters_.clusters; }
  [[nodiscard]] const std::vector<FlowVector>& flow_vectors() const { return state_.scene_flow.vectors(); }
  [[nodiscard]] std::size_t flow_points() const { return state_.scene_flow.points_reserved(); }
  [[nodiscard]] NearObstacles& near() { return state_.near; }
  /// Null: GroundModel::plane.
  [[nodiscard]] FrameTerrain* terrain() { return state_.terrain ? &*state_.terrain : nullptr; }

 private:
  [[nodiscard]] TerrainPlace place_of(const FrameGrids& grids) const;
  [[nodiscard]] MatchedFrame matched(const LevelFrame& frame) const;
  [[nodiscard]] FlowFrame flow_frame(const LevelFrame& frame) const;
  void track_features(CameraFrame& now);
  bool align(const LevelFrame& frame, const Ground& expected);
  void align_first(const CameraFrame& now);
  bool find_own_surface(const LevelFrame& frame);
  GroundFit fit_ground(CameraFrame& now);
  GroundFit rematch(CameraFrame& now, const GroundFit& ground);
  TerrainRules find_terrain(CameraFrame& now);
  [[nodiscard]] float blur_in(const LevelFrame& frame) const;

  Config config_;
  Rig rig_;
  double turned_rad_;
  Cpu& cpu_;
  std::unique_ptr<Stages> stages_;
  GroundEstimator estimator_;
  GroundState first_ground_;
  CameraState state_;

  // working memory
  GroundWorkspace ground_space_;
  ClusterWorkspace clusters_;
};

}  // namespace stereogrid
