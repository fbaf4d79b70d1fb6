// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "pipeline/cuda/frame.hpp"
#include "pipeline/journey.hpp"

namespace stereogrid {

/// The way of a frame on a GPU. Two graphs: match (images up, disparities and ground) and grids (counting to filter,
/// results down). While the second runs, the host measures row offsets and looks whether the road is lost; then the
/// frame is done again, from the same state of the filter. So are the grids of a frame that turns out not to be
/// reliable: with nothing observed.
class JourneyOnCuda final : public Journey {
 public:
  /// Throws DeviceError: no device that can be used, too little memory, or settings that only the CPU can do.
  JourneyOnCuda(const Config& config, const Rig& rig);

  void run(const JourneyInput& input, FrameResult& result) override;
  void forget() override;
  void start_ids_at(std::int64_t first_id) override { tracker_.start_ids_at(first_id); }
  int threads() override { return 1; }
  [[nodiscard]] MemoryUse memory_use() const override;
  void fetch_stages(bool wanted) override { are_stages_wanted_ = wanted; }
  void save(StateWriter& state) override;
  void load(StateReader& state) override;
  /// Of the last frame.
  [[nodiscard]] const StreamTimes& times() const { return times_; }

 private:
  void take(const JourneyInput& input);
  void expect(const Ground& expected);
  void find_first_ground(const JourneyInput& input, const Ground& expected);
  [[nodiscard]] bool is_answered_lost() const;
  bool search_if_lost();
  void measure_rows(const JourneyInput& input, const Ground& ground);
  [[nodiscard]] bool flows() const { return config_.filter.scene_flow && !is_given_; }
  [[nodiscard]] FlowFrame flow_frame(const JourneyInput& input) const;
  void follow_points(const JourneyInput& input);
  void judge(const JourneyInput& input, const Ground& expected);
  void finish(const JourneyInput& input, FrameResult& result);

  void match_frame();
  void make_grids();
  void do_or_repeat(Graph& graph, const std::function<void()>& work);
  void record_match();
  void record_grids();
  void project_grids();
  void fetch_matches();
  void scatter_lattice();
  template <class State>
  void exchange(State& state);

  const CudaBytes allocated_before_{cuda_bytes_allocated()};  // before the other members are
  Config config_;
  Rig rig_;
  Cuda cuda_;
  StreamTimes times_;
  bool are_stages_wanted_{true};

  // between frames
  Ground ground_;
  FrameTrust trust_;
  Doubt doubt_{Doubt::none};  ///< of this frame: may the grids be built on it?
  int frames_to_search_{0};
  bool is_first_{true};
  bool is_given_{false};  ///< disparities, in this frame
  bool had_other_grids_{false};
  RowAlignment alignment_;
  Window window_;
  GridGeometry vehicle_grid_;
  GridGeometry window_before_;
  FilterTables filter_tables_;
  SceneFlow scene_flow_;
  EvidenceMap velocity_evidence_;
  Tracker tracker_;

  // working memory
  Matches matches_;
  GroundSpace ground_samples_;
  ClusterSpace clusters_;
  HostMemory host_;
  double flow_ms_{0};
  DeviceMemory device_;
  CudaBytes held_{cuda_bytes_allocated() - allocated_before_};  // by the members so far
  int now_{0};                                                  ///< device_.states[now_] is written in this frame

  std::array<Graph, 2> match_graphs_;  ///< [is_given_]
  std::array<Graph, 2> grid_graphs_;   ///< [now_]
  std::array<Graph, 2> blank_graphs_;  ///< [now_], of frames that cannot be relied on
};

}  // namespace stereogrid
