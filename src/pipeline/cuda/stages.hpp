// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <mutex>
#include <span>
#include <vector>

#include "obstacles/segmentation/cuda.hpp"
#include "pipeline/cuda/frame.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {

/// The stages on a GPU. Each call is recorded as a graph the first time and repeated from then on. The device works on
/// the grids while the host validates the frame; a frame that is matched again or rejected has its grids made again,
/// from the same state of the filter.
class CudaStages final : public Stages {
 public:
  /// Throws DeviceError: no usable device, or too little memory.
  CudaStages(const Config& config, const Rig& level_rig, int device = 0, const StagesOptions& options = {});
  ~CudaStages() override;

  void match(const LevelFrame& frame, const FrameGrids& grids, const RowAlignment& rows,
             const MatchGround& ground) override;
  const Matches& read() override;
  const float* begin_walk(const WalkFrame& frame) override;
  void begin_low_obstacles(const LowModel& model, std::span<const float> noise_px) override;
  void find_ground(FrameTerrain& terrain, FrameResult& result) override;
  void finish_ground(FrameTerrain& terrain, FrameResult& result) override;
  void observe(const FrameGrids& grids, const Evidence& evidence, FrameResult& result) override;
  void fuse_cameras(std::span<const CameraGrids> cameras, FrameResult& result) override;
  std::span<const ColumnNode> find_nodes(const Ground& ground, Relief<Host>& relief) override;
  void filter(const FrameGrids& grids, const FilterEvidence& evidence, FrameResult& result) override;
  View<const float> filtered(const FrameResult& result) override;
  void finish(const FrameGrids& grids, const FinalStep& step, FrameResult& result) override;
  void publish(const FrameGrids& grids, FrameResult& result) override;
  void publish_matches(FrameResult& result) override;
  void fetch(const DeviceImages& images, StereoFrame& into) override;
  DeviceGrids device_grids() override;
  void exchange(StateArchive archive) override;
  /// Matching is recorded again where other rows are masked.
  void set_mask(PixelMask mask) override;

  /// Launches each kernel by itself from now on, not in graphs, and notifies `watch`.
  void go_without_graphs(LaunchWatch& watch) {
    cuda_.watch(&watch);
    beside_.watch(&watch);
    has_graphs_ = false;
  }
  /// Times of the last frame.
  [[nodiscard]] const StreamTimes& times() const { return times_; }

 private:
  [[nodiscard]] bool counts_rays() const { return config_.projection.model == ProjectionModel::rays; }
  [[nodiscard]] bool has_terrain() const { return config_.ground.model == GroundModel::terrain; }
  void load_kernels();
  void load_mask();
  void put_frame(const LevelFrame& frame, const FrameGrids& grids);
  void put_set(const FrameGrids& grids);
  void put_ground(Cuda& cuda, const Ground& ground);
  void synchronize();
  template <class Work>
  void perform(Cuda& cuda, Graph& graph, const Work& work);
  void join();
  void enqueue_match();
  void enqueue_walk(const WalkFrame& frame);
  void find_low_obstacles();
  void find_ground();
  void split_given(const Ground* ground);
  void split_surfaces();
  void enqueue_observation(bool is_usable);
  void count_nodes();
  void begin_count();
  void count();
  void project(Cuda& cuda, const GridInVehicle* grid, const CellRule* rules, DeviceImage<float>& cells);
  void project_to_vehicle();
  void enqueue_filter(bool has_others);
  void enqueue_finish(const FinalStep& step);
  void scatter_lattice();
  void clear_masked();
  void save(StateWriter& state);
  void load(StateReader& state);

  const CudaBytes allocated_before_{cuda_bytes_allocated()};  // before the other members are
  Config config_;
  Rig rig_;
  Cuda cuda_;
  Cuda beside_;  ///< work that waits for the host only, and that cuda_ waits for
  StreamTimes times_;
  StagesOptions options_;
  bool has_graphs_{true};
  GridSizes sizes_;
  FilterTables filter_tables_;
  DeviceMemory device_;
  HostMemory host_;
  ColumnsOnDevice columns_;
  LowObstaclesOnDevice low_obstacles_;
  GroundOnDevice ground_;
  Matches matches_;                                             ///< see read()
  CudaBytes held_{cuda_bytes_allocated() - allocated_before_};  // by the members so far

  // data of a frame
  bool is_external_{false};  ///< external disparities
  bool has_observed_{false};
  bool is_one_of_several_{false};  ///< its observed grid is fused with those of other cameras
  bool is_at_work_{false};         ///< since the last synchronize()
  bool is_filtering_{false};       ///< likewise: filter()
  std::mutex reading_;
  bool is_lattice_taken_{false};

  // between frames
  GridGeometry window_before_;  ///< window of the last completed frame
  int now_{0};                  ///< device_.states[now_] is written in this frame
  bool has_grids_{false};       ///< grids of a completed frame

  std::array<Graph, 2> match_graphs_;  ///< [is_external_]
  Graph low_obstacles_graph_;
  Graph ground_graph_;
  std::array<Graph, 2> observe_graphs_;  ///< [is_usable]
  Graph vehicle_graph_;
  std::array<std::array<Graph, 2>, 2> filter_graphs_;  ///< [with other grids][now_]
  std::array<std::array<Graph, 2>, 2> finish_graphs_;  ///< [is_corrected][is_widened]
};

}  // namespace stereogrid
