// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "pipeline/cuda/frame.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {

/// The stages on a GPU. What FrameProcessor performs is recorded as a graph the first time and repeated from then on:
/// match (images up, disparities and ground down) and grids (counting to filter, results down). While the second runs,
/// the host decides; where it finds that the frame has to be matched again, or cannot be relied on, the grids are made
/// again from the same state of the filter.
class CudaStages final : public Stages {
 public:
  /// Throws DeviceError: no device that can be used, or too little memory.
  CudaStages(const Config& config, const Rig& level_rig, int device = 0);
  ~CudaStages() override;

  void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) override;
  void expect(const Ground& expected, const Ground& previous, const RowAlignment& rows) override;
  void take_velocities(std::span<const VelocityEvidence> evidence) override;
  void hold(std::span<const HeldCell> cells) override;

  void match() override;
  void estimate_ground() override;
  void count() override;
  void project() override;
  void observe_nothing() override;
  void fuse() override;
  void filter() override;
  void weigh_velocities() override;
  void resample() override;
  void perform(StagePart part, const std::function<void()>& work) override;
  [[nodiscard]] bool works_ahead() const override { return true; }

  Ground ground() override;
  bool is_lost() override;
  const Matches& matches_on_lattice() override;
  const Matches& unsplit_matches() override;
  View<const float> obstacle_disparity() override;
  void take_ahead(View<const std::uint8_t> left, View<const std::uint8_t> right) override;
  void finish() override;

  /// From now on each kernel is started by itself, and `watch` told of it, instead of graphs of them.
  void go_without_graphs(LaunchWatch& watch) {
    cuda_.watch(&watch);
    has_graphs_ = false;
  }
  void fetch_stages(bool wanted) override { are_stages_wanted_ = wanted; }
  void take_mask(const PixelMask& mask) override;
  [[nodiscard]] MemoryUse memory_use() const override;
  void save(StateWriter& state) override;
  void load(StateReader& state) override;
  /// Of the last frame.
  [[nodiscard]] const StreamTimes& times() const { return times_; }

 private:
  [[nodiscard]] bool is_given() const { return images_ == FrameImages::given; }
  [[nodiscard]] bool counts_rays() const { return config_.projection.model == ProjectionModel::rays; }
  void synchronize();
  Graph& graph_of(StagePart part);
  void scatter_lattice();
  void clear_masked();

  const CudaBytes allocated_before_{cuda_bytes_allocated()};  // before the other members are
  Config config_;
  Rig rig_;
  Cuda cuda_;
  StreamTimes times_;
  bool are_stages_wanted_{true};
  bool has_graphs_{true};
  const PixelMask* mask_{nullptr};
  GridGeometry vehicle_grid_;
  int window_cells_;
  FilterTables filter_tables_;
  HostMemory host_;
  DeviceMemory device_;
  SideCopy ahead_;   ///< of the images of a frame in flight; waits, before the memory goes
  Matches matches_;  ///< see matches_on_lattice
  CudaBytes held_{cuda_bytes_allocated() - allocated_before_};  // by the members so far

  // of a frame
  FrameResult* result_{nullptr};
  bool is_first_{true};
  FrameImages images_{};
  bool has_other_grids_{false};    ///< this frame
  double dt_s_{0};                 ///< since the frame before
  bool is_at_work_{false};         ///< since the last synchronize()
  bool are_grids_in_work_{false};  ///< the device may be reading what the host has handed over
  bool is_lattice_taken_{false};

  // between frames
  GridGeometry window_before_;  ///< of the last frame that has been finished
  int now_{0};                  ///< device_.states[now_] is written in this frame

  std::array<Graph, 3> match_graphs_;                   ///< [images_]
  std::array<std::array<Graph, 2>, 2> grid_graphs_;     ///< [now_][has_other_grids_]
  std::array<std::array<Graph, 2>, 2> unknown_graphs_;  ///< [now_][has_other_grids_]
};

}  // namespace stereogrid
