// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

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

  void set_mask(const PixelMask& mask) override;
  void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) override;
  void match(const Ground& expected, const Ground& previous, const RowAlignment& rows) override;
  void estimate_ground() override;
  void set_ground(const Ground& ground) override;
  void set_rules(const TerrainRules& rules) override;
  void set_blur(float blur_px) override;
  void observe(bool is_usable, std::span<const HeldCell> held) override;
  void filter(std::span<const VelocityEvidence> velocities) override;
  void finish() override;

  [[nodiscard]] bool is_asynchronous() const override { return true; }
  Ground ground() override;
  bool is_lost() override;
  const Matches& matches_on_lattice() override;
  View<const float> obstacle_disparity() override;
  View<const float> road_disparity() override;

  /// Launches each kernel by itself from now on, not in graphs, and notifies `watch`.
  void go_without_graphs(LaunchWatch& watch) {
    cuda_.watch(&watch);
    has_graphs_ = false;
  }
  [[nodiscard]] MemoryUse memory_use() const override;
  void save(StateWriter& state) override;
  void load(StateReader& state) override;
  /// Times of the last frame.
  [[nodiscard]] const StreamTimes& times() const { return times_; }

 private:
  [[nodiscard]] bool counts_rays() const { return config_.projection.model == ProjectionModel::rays; }
  void load_kernels();
  void synchronize();
  template <class Work>
  void perform(Graph& graph, const Work& work);
  void enqueue_match();
  void enqueue_ground();
  void enqueue_answer();
  void split_given(const Ground* ground);
  void split_surfaces();
  void enqueue_observation(bool is_usable);
  void count();
  void project();
  void fuse();
  void enqueue_filter();
  void scatter_lattice();
  void fetch_answer();
  void wait_for_answer();
  void clear_masked();

  const CudaBytes allocated_before_{cuda_bytes_allocated()};  // before the other members are
  Config config_;
  Rig rig_;
  Cuda cuda_;
  StreamTimes times_;
  StagesOptions options_;
  bool has_graphs_{true};
  const PixelMask* mask_{nullptr};
  GridGeometry vehicle_grid_;
  int window_cells_;
  FilterTables filter_tables_;
  DeviceMemory device_;
  HostMemory host_;
  Matches matches_;                                             ///< see matches_on_lattice
  CudaBytes held_{cuda_bytes_allocated() - allocated_before_};  // by the members so far

  // result of a frame
  FrameResult* result_{nullptr};
  bool is_first_{true};
  bool is_given_{false};           ///< external disparities
  bool has_other_grids_{false};    ///< this frame
  double dt_s_{0};                 ///< since the frame before
  bool is_at_work_{false};         ///< since the last synchronize()
  bool are_grids_in_work_{false};  ///< the device may be reading the host's grids
  bool is_answer_fetched_{false};  ///< the host's matches are those of the device
  bool is_lattice_taken_{false};

  // between frames
  GridGeometry window_before_;  ///< window of the last completed frame
  int now_{0};                  ///< device_.states[now_] is written in this frame

  std::array<Graph, 2> match_graphs_;    ///< [is_given_]
  std::array<Graph, 2> ground_graphs_;   ///< [is_given_]
  std::array<Graph, 2> observe_graphs_;  ///< [has_other_grids_]
  std::array<Graph, 2> unknown_graphs_;  ///< [has_other_grids_]
  std::array<Graph, 2> filter_graphs_;   ///< [now_]
};

}  // namespace stereogrid
