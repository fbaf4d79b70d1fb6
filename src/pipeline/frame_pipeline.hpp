// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "motion/velocity_evidence.hpp"
#include "obstacles/tracking/tracking.hpp"
#include "pipeline/camera_pipeline.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {

/// Extrinsics that replace those of a camera's rig.
struct NewExtrinsics {
  int camera;
  Ground ground;  ///< relative to the level rig
};

using GridsHandler = std::function<void(std::span<const NewExtrinsics>)>;

/// A frame through all stages, on any back end: each camera's own ones, then one window, filter and list of tracks.
/// State between frames is in the cameras' states, the tracker and the filter's state. A stage of process() reads
/// only what an earlier one has returned.
class FramePipeline {
 public:
  /// The first camera's stages have the filter. All are of the same back end. `cpu` must outlive the pipeline.
  FramePipeline(const Config& config, Cpu& cpu, std::vector<CameraSetup> cameras);
  /// One camera.
  FramePipeline(const Config& config, const Rig& level_rig, Cpu& cpu, std::unique_ptr<Stages> stages,
                double turned_rad = 0, GroundMode mode = GroundMode::given);

  /// Processes one frame. `result` keeps status and warnings that it has, as do those of several cameras. Returns
  /// extrinsics that replace those of rigs: this frame needs a pipeline for rigs with them. Valid until the next call.
  /// `on_grids` is called with them when only obstacles and times are missing in `result`.
  std::span<const NewExtrinsics> process(const FrameSet& frame, FrameResult& result, const GridsHandler& on_grids = {});
  /// Makes the next frame a first one. Ids of obstacles continue.
  void reset();
  /// Replaces the pixels without disparities.
  void set_mask(int camera, PixelMask mask) { at(camera).stages().set_mask(std::move(mask)); }
  /// See Stages.
  void fetch(int camera, const DeviceImages& images, StereoFrame& into) { at(camera).stages().fetch(images, into); }
  [[nodiscard]] DeviceGrids device_grids() { return at(0).stages().device_grids(); }
  /// Continues the ids of obstacles of `before`, and what it has found of the vehicle itself.
  void continue_from(const FramePipeline& before);

  /// State between two frames: saved or loaded.
  template <class State>
  void exchange(State& state) {
    state(is_first_, tracker_);
    for (const std::unique_ptr<CameraPipeline>& camera : cameras_) camera->exchange(state);
  }
  [[nodiscard]] MemoryUse memory_use() const;

 private:
  [[nodiscard]] bool has_one_camera() const { return cameras_.size() == 1; }
  [[nodiscard]] CameraPipeline& at(int camera) { return *cameras_[static_cast<std::size_t>(camera)]; }
  [[nodiscard]] CameraPipeline& of(const CameraFrame& now) { return at(now.frame.camera); }
  /// Calls work(camera, now) for each camera of the frame, at the same time if there are threads for it.
  template <class Work>
  void for_cameras(const Work& work);
  [[nodiscard]] FrameGrids grids_of(const FrameSet& frame, const Pose2& world_from_camera) const;
  void look(const FrameSet& frame, FrameResult& result);
  [[nodiscard]] bool has_frame(int camera) const;
  /// Each camera's observation, all of them in one window, and a step of the filter. `is_checked`: without unusable
  /// ones.
  void filter(const FrameGrids& grids, bool is_checked, FrameResult& result);
  [[nodiscard]] std::span<const VelocityEvidence> find_velocities(const FrameGrids& grids);
  [[nodiscard]] std::span<const RetainedCell> held_cells(bool is_checked);
  void find_terrains();
  void publish(const FrameGrids& grids, FrameResult& result);
  [[nodiscard]] FinalStep final_step(const FrameSet& frame, FrameResult& result);
  void limit_speed(double dt_s, FrameResult& result);
  void fuse_terrain(FrameResult& result);
  void update_tracks(const FrameSet& frame, FrameResult& result);
  [[nodiscard]] std::vector<Cluster>& find_clusters(const GridLayers& world);
  void report_cameras(FrameResult& result);

  Config config_;
  Cpu& cpu_;
  std::vector<std::unique_ptr<CameraPipeline>> cameras_;
  Window window_;
  bool is_first_{true};
  Tracker tracker_;

  // working memory
  std::vector<CameraFrame> now_;  // the frame's cameras
  EvidenceMap velocity_evidence_;
  HeldObstacles held_;
  std::vector<FlowVector> vectors_;  // features of several cameras
  std::vector<Cluster> clusters_;
  std::vector<CameraGrids> observed_;
  std::vector<const FrameTerrain*> terrains_;
  std::vector<NewExtrinsics> new_extrinsics_;
  double filter_flow_ms_{0};
};

}  // namespace stereogrid
