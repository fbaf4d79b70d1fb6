// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <type_traits>

#include "backend/cpu.hpp"
#include "filter/filter.hpp"
#include "fusion/fusion.hpp"
#include "matching/checks/external.hpp"
#include "matching/matching.hpp"
#include "observation/projection/projection.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/u_disparity.hpp"
#include "pipeline/host_workspace.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {

/// The stages in the host's memory, on Cpu or Reference.
template <class BackEndType>
class HostStages final : public Stages {
 public:
  /// `cpu`: threads of what every back end does alike. Both must outlive the stages.
  HostStages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options, BackEndType& back_end)
      : Stages{options.mask},
        config_{config},
        rig_{level_rig},
        options_{options},
        cpu_{cpu},
        back_end_{back_end},
        space_{config, rig_, vehicle_grid_of(config.grid), cpu.threads(), options.filters},
        columns_{rig_, config.u_disparity, config.matching.disparities} {
    make_room(back_end_, config.matching, space_.matching);
    if (options.predictions)
      space_.prediction = std::make_unique<PredictionWorkspace>(space_.next.occupancy.width(), config.filter);
    set_memory_use({sizeof *this + space_.memory_bytes() + columns_.memory_bytes(), 0});
  }

  void match(const LevelFrame& frame, const FrameGrids&, const RowAlignment& rows, const MatchGround& ground) override {
    const ScopedTimer timer{times_.match};
    HostWorkspace& s{space_};
    if (ground.surface != nullptr) {
      split_surfaces(back_end_, frame.disparity, rig_, ground.plane, *ground.surface, config_.matching, s.heights,
                     s.matches);
    } else if (frame.has_external_disparity()) {
      split(back_end_, frame.disparity, rig_, ground.plane, config_.matching, s.matches);
    } else {
      stereogrid::match(back_end_, frame.left, aligned(frame.right, rows), road_plane(rig_, ground.plane),
                        config_.matching, s.matching, s.matches);
    }
    clear_masked();
  }

  const Matches& read() override { return space_.matches; }

  const float* begin_walk(const WalkFrame& frame) override {
    const Matches& matches{space_.matches};
    return space_.walks.begin(frame, matches.obstacle.view(), matches.road.view(), ranges_of(cpu_));
  }

  void begin_low_obstacles(const LowModel& model, std::span<const float> noise_px) override {
    const Matches& matches{space_.matches};
    low_ = space_.low_obstacles.find(matches.obstacle.view(), matches.road.view(), model, noise_px, ranges_of(cpu_));
  }

  void find_ground(FrameTerrain& terrain, FrameResult& result) override {
    terrain.set_walked(space_.walks.find(ranges_of(cpu_)));
    terrain.find_ground(ranges_of(cpu_), result);
    terrain.mark_low_obstacles(low_, result);
  }

  void finish_ground(FrameTerrain&, FrameResult&) override {}

  void observe(const FrameGrids& grids, const Evidence& evidence, FrameResult& result) override {
    if (evidence.is_usable) {
      count(evidence, result.stages);
      project(grids, evidence, result);
    } else {
      result.observed.fill(0.5f);
      space_.observed_world.fill(0.5f);
    }
  }

  void fuse_cameras(std::span<const CameraGrids> cameras, FrameResult& result) override {
    const auto fuse_as = [&](View<float> cells, const auto& observed_by) {
      std::array<View<const float>, cameras_max> observed;
      std::ranges::transform(cameras, observed.begin(), observed_by);
      const std::span used{observed.data(), cameras.size()};
      ranges_of(cpu_)(cells.height, [&](int begin, int end) { fuse_camera_rows(used, begin, end, cells); });
    };
    fuse_as(result.observed.view(), [](const CameraGrids& camera) { return camera.result->observed.view(); });
    fuse_as(space_.observed_world.view(), [](const CameraGrids& camera) {
      return std::as_const(static_cast<HostStages*>(camera.stages)->space_.observed_world).view();
    });
  }

  std::span<const ColumnNode> find_nodes(const Ground& ground, Relief<Host>& relief) override {
    return columns_.find(std::as_const(space_.matches.obstacle).view(), ground, relief, ranges_of(cpu_));
  }

  void filter(const FrameGrids& grids, const FilterEvidence& evidence, FrameResult& result) override {
    fuse(grids, evidence.held, result.observed);
    const ScopedTimer timer{times_.filter};
    HostWorkspace& s{space_};
    const FrameSet& frame{grids.frame};
    const std::span views{frame.views};
    const CameraView view{views.empty() ? CameraView{} : views.front()};
    if (grids.is_first) reset(s.filtered, config_.filter, grids.window);
    const bool is_reused{&result == options_.reused};
    const std::vector<BlockKind>* const kinds_before{is_reused ? &s.block_kinds : nullptr};
    stereogrid::filter(back_end_,
                       {config_.filter, s.filter_tables, grids.window, frame.dt_s, view, kinds_before,
                        views.empty() ? views : views.subspan(1)},
                       s.observed_world.view(), s.filtered, s.next, result.world);
    if (is_reused) s.block_kinds = s.next.kinds;  // kinds of the blocks that the result's layers now have
    if (config_.filter.model == FilterModel::joint) {
      stereogrid::weigh_velocities(back_end_, evidence.velocities, s.filter_tables, s.weighing, s.next, result.world);
      if (is_reused) s.block_kinds = s.next.kinds;
    }
    resample(frame.world_from_vehicle, {&s.next.kinds, is_reused ? &s.part_kinds : nullptr}, result);
  }

  View<const float> filtered(const FrameResult& result) override { return result.world.occupancy.view(); }

  void finish(const FrameGrids& grids, const FinalStep& step, FrameResult& result) override {
    const ScopedTimer timer{times_.filter};
    const Pose2& pose{grids.frame.world_from_vehicle};
    if (step.is_corrected) {
      ranges_of(cpu_)(result.observed.height(),
                      [&](int begin, int end) { correct_by_frame(pose, step.is_widened, begin, end, result); });
    }
    bound_grids(step.bounds, result);
    if (step.is_completed) complete_unobserved(pose, result);
  }

  void publish(const FrameGrids& grids, FrameResult& result) override {
    std::swap(space_.filtered, space_.next);
    if (options_.predictions) predict(grids.frame.world_from_vehicle, result);
    result.timing_ms = std::exchange(times_, {});
  }

  void publish_matches(FrameResult& result) override {
    const Matches& matches{space_.matches};
    const auto obstacles = [&] {
      result.obstacle_density = share_matched(matches.obstacle);
      if (options_.stage_images) set_obstacles(matches.obstacle.view(), result.stages);
    };
    const auto road = [&] {
      result.road_density = share_matched(matches.road);
      if (options_.stage_images) result.stages.road_disparity = matches.road;
    };
    cpu_.together(obstacles, road);
    if (options_.stage_images) result.stages.match_confidence = matches.confidence;
  }

  void fetch(const DeviceImages&, StereoFrame&) override { throw_without_device(); }
  DeviceGrids device_grids() override { throw_without_device(); }

  void exchange(StateArchive archive) override {
    std::visit([this](auto* state) { (*state)(space_.filtered); }, archive);
  }

 private:
  [[noreturn]] static void throw_without_device() {
    throw ConfigError{
        "This pipeline runs on the CPU and has no device memory. Give images in the host's memory, or the back end "
        "cuda; Pipeline::why_not_cuda() has the reason of automatic."};
  }

  // A prediction is a step in which nothing is seen.
  void predict(const Pose2& world_from_vehicle, FrameResult& result) {
    PredictionWorkspace& ahead{*space_.prediction};
    for (Prediction& prediction : result.predictions) {
      stereogrid::filter(back_end_, {config_.filter, space_.filter_tables, result.world.geometry, prediction.horizon_s},
                         ahead.nothing.view(), space_.filtered, ahead.state, ahead.layers);
      prediction.world_occupancy = ahead.layers.occupancy;
      resample_occupancy(ahead.layers, world_from_vehicle, result.vehicle.geometry, prediction.occupancy);
    }
  }

  void count(const Evidence& evidence, StageImages& stages) {
    const ScopedTimer timer{times_.count};
    HostWorkspace& s{space_};
    s.rays.blur_px = evidence.blur_px;
    s.rays.relief = evidence.rules.relief;
    if (counts_rays()) count_rays(back_end_, s.matches, rig_, evidence.ground, config_.u_disparity, s.rays);
    if (counts_rays() && !options_.stage_images) return;
    stereogrid::count(back_end_, s.matches, rig_, evidence.ground, s.u_disparity_tables, s.u_disparity, stages);
  }

  void project(const FrameGrids& grids, const Evidence& evidence, FrameResult& result) {
    const ScopedTimer timer{times_.project};
    const View<const float> occupancy{std::as_const(result.stages.occupancy_smooth).view()};
    project_to(grids.seen_vehicle, occupancy, result.observed);
    project_to(grids.seen_window, occupancy, space_.observed_world);
    apply(evidence.rules.vehicle, result.observed);
    apply(evidence.rules.window, space_.observed_world);
  }

  void project_to(const GridInVehicle& grid, View<const float> occupancy, Image<float>& cells) {
    const BinGeometry bins{rig_};
    if (counts_rays()) return project_rays(back_end_, space_.rays, bins, grid, cells.view());
    stereogrid::project(back_end_, occupancy, bins, grid, space_.projection, cells.view());
  }

  void apply(View<const CellRule> rules, Image<float>& cells) {
    cpu_.for_ranges(rules.height, 8, [&](int begin, int end) {
      for (int y{begin}; y < end; ++y) apply_rules(rules.row(y), rules.width, cells.row(y));
    });
  }

  void fuse(const FrameGrids& grids, std::span<const RetainedCell> held, Image<float>& observed) {
    const ScopedTimer timer{times_.project};
    const std::span others{grids.frame.other_grids};
    stereogrid::fuse(back_end_, others, grids.vehicle, config_.fusion, observed.view());
    stereogrid::fuse(back_end_, others, grids.window_cells, config_.fusion, space_.observed_world.view());
    for (const RetainedCell& one : held) {
      float& cell{space_.observed_world.data()[one.cell]};
      cell = std::max(cell, one.occupancy);
    }
  }

  void resample(const Pose2& pose, KnownKinds kinds, FrameResult& result) {
    if constexpr (std::is_same_v<BackEndType, Reference>) return stereogrid::resample(pose, result);
    cpu_.for_ranges(result.vehicle.geometry.ny, 8,
                    [&](int begin, int end) { resample_rows(pose, begin, end, kinds, result); });
  }

  void clear_masked() {
    if (mask().empty()) return;
    cpu_.for_ranges(mask().end_row() - mask().first_row(), 8,
                    [this](int begin, int end) { mask().clear(begin, end, space_.matches); });
  }

  View<const std::uint8_t> aligned(View<const std::uint8_t> right, const RowAlignment& rows) {
    if (rows.is_identity()) return right;
    align_rows(back_end_, right, rows.offsets(), space_.aligned_right.view());
    return space_.aligned_right.view();
  }

  [[nodiscard]] bool counts_rays() const { return config_.projection.model == ProjectionModel::rays; }

  Config config_;
  Rig rig_;
  StagesOptions options_;
  Cpu& cpu_;
  BackEndType& back_end_;
  HostWorkspace space_;
  ColumnCounter columns_;
  std::span<const LowCell> low_;
  StageTimes times_;  ///< times of a frame's stages
};

}  // namespace stereogrid
