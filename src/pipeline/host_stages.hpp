// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <type_traits>

#include "backend/cpu.hpp"
#include "filter/filter.hpp"
#include "fusion/fusion.hpp"
#include "ground/ground.hpp"
#include "matching/checks/external.hpp"
#include "matching/matching.hpp"
#include "observation/projection/projection.hpp"
#include "observation/rays/rays.hpp"
#include "observation/u_disparity/u_disparity.hpp"
#include "pipeline/host_space.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/stopwatch.hpp"

namespace stereogrid {

/// The stages in the host's memory, on Cpu or Reference.
template <class BackEndType>
class HostStages final : public Stages {
 public:
  /// `cpu`: threads of what every back end does alike. Both must outlive the stages.
  HostStages(const Config& config, const Rig& level_rig, Cpu& cpu, const StagesOptions& options, BackEndType& back_end)
      : config_{config},
        rig_{level_rig},
        options_{options},
        cpu_{cpu},
        back_end_{back_end},
        space_{config, rig_, vehicle_grid_of(config.grid), cpu.threads()} {
    make_room(back_end_, config.matching, space_.matching);
    if (options.predictions)
      space_.prediction = std::make_unique<PredictionSpace>(space_.filtered.occupancy.width(), config.filter);
  }

  void set_mask(const PixelMask& mask) override { mask_ = &mask; }

  void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) override {
    frame_ = frame;
    result_ = &result;
    window_ = window;
    vehicle_cells_ = grid_in_vehicle(result.vehicle.geometry, {});
    window_cells_ = grid_in_vehicle(window, inverse(frame.world_from_vehicle));
    times_ = {};
    rules_ = {};
    std::swap(space_.filtered, space_.filtered_before);
    if (is_first) reset(space_.filtered_before, config_.filter, window);
  }

  void match(const Ground& expected, const Ground& previous, const RowAlignment& rows) override {
    const ScopedTimer timer{times_.match};
    previous_ = previous;
    rows_ = &rows;
    match_on(expected);
  }

  void estimate_ground() override {
    const ScopedTimer timer{times_.ground};
    HostSpace& s{space_};
    is_lost_ = stereogrid::is_lost(rig_, config_.ground, s.matches.obstacle.view(), s.matches.road.view(), previous_,
                                   s.ground_samples);
    ground_ = stereogrid::estimate_ground(rig_, config_.ground, s.matches.road.view(), previous_, frame_.dt_s,
                                          s.ground_samples);
    if (frame_.is_given()) match_on(ground_);  // splitting is cheap, and the plane is better now
  }

  void set_ground(const Ground& ground) override { ground_ = ground; }
  void set_rules(const TerrainRules& rules) override {
    rules_ = rules;
    if (!frame_.is_given()) return;
    const ScopedTimer timer{times_.match};
    split_surfaces(back_end_, frame_.disparity, rig_, ground_, rules.relief, config_.matching, space_.heights,
                   space_.matches);
    clear_masked();
  }
  void set_blur(float blur_px) override { space_.rays.blur_px = blur_px; }

  void observe(bool is_usable, std::span<const HeldCell> held) override {
    if (is_usable) {
      count();
      project();
    } else {
      result_->observed.fill(0.5f);
      space_.observed_world.fill(0.5f);
    }
    fuse(held);
  }

  void filter(std::span<const VelocityEvidence> velocities) override {
    const ScopedTimer timer{times_.filter};
    HostSpace& s{space_};
    const std::vector<BlockKind>* const kinds_before{is_reused() ? &s.block_kinds : nullptr};
    stereogrid::filter(back_end_, {config_.filter, s.filter_tables, window_, frame_.dt_s, frame_.view, kinds_before},
                       s.observed_world.view(), s.filtered_before, s.filtered, result_->world);
    keep_block_kinds();
    if (config_.filter.model == FilterModel::joint) {
      stereogrid::weigh_velocities(back_end_, velocities, s.filter_tables, s.weighing, s.filtered, result_->world);
      keep_block_kinds();
    }
    resample();
  }

  Ground ground() override { return ground_; }
  bool is_lost() override { return is_lost_; }
  const Matches& matches_on_lattice() override { return space_.matches; }
  View<const float> obstacle_disparity() override { return space_.matches.obstacle.view(); }
  View<const float> road_disparity() override { return space_.matches.road.view(); }

  void finish() override {
    const Matches& matches{space_.matches};
    const auto obstacles = [&] {
      result_->obstacle_density = share_matched(matches.obstacle);
      if (options_.stage_images) result_->stages.obstacle_disparity = matches.obstacle;
    };
    const auto road = [&] {
      result_->road_density = share_matched(matches.road);
      if (options_.stage_images) result_->stages.road_disparity = matches.road;
    };
    cpu_.together(obstacles, road);
    if (options_.stage_images) result_->stages.match_confidence = matches.confidence;
    result_->timing_ms = times_;
  }

  [[nodiscard]] MemoryUse memory_use() const override { return {sizeof *this + space_.held_bytes(), 0}; }
  void save(StateWriter& state) override { state(space_.filtered); }
  void load(StateReader& state) override { state(space_.filtered); }

  // A prediction is a step in which nothing is seen.
  void predict(const Pose2& world_from_vehicle, FrameResult& result) override {
    PredictionSpace& ahead{*space_.prediction};
    for (Prediction& prediction : result.predictions) {
      stereogrid::filter(back_end_, {config_.filter, space_.filter_tables, result.world.geometry, prediction.horizon_s},
                         ahead.nothing.view(), space_.filtered, ahead.state, ahead.layers);
      prediction.world_occupancy = ahead.layers.occupancy;
      resample_occupancy(ahead.layers, world_from_vehicle, result.vehicle.geometry, prediction.occupancy);
    }
  }

 private:
  void match_on(const Ground& ground) {
    HostSpace& s{space_};
    if (frame_.is_given()) {
      split(back_end_, frame_.disparity, rig_, ground, config_.matching, s.matches);
    } else {
      stereogrid::match(back_end_, frame_.left, aligned(frame_.right), road_plane(rig_, ground), config_.matching,
                        s.matching, s.matches);
    }
    clear_masked();
  }

  void count() {
    const ScopedTimer timer{times_.count};
    space_.rays.relief = rules_.relief;
    if (counts_rays()) count_rays(back_end_, space_.matches, rig_, ground_, config_.u_disparity, space_.rays);
    if (counts_rays() && !options_.stage_images) return;
    stereogrid::count(back_end_, space_.matches, rig_, ground_, space_.u_disparity_tables, space_.u_disparity,
                      result_->stages);
  }

  void project() {
    const ScopedTimer timer{times_.project};
    project_to(vehicle_cells_, result_->observed);
    project_to(window_cells_, space_.observed_world);
    apply(rules_.vehicle, result_->observed);
    apply(rules_.window, space_.observed_world);
  }

  void apply(View<const CellRule> rules, Image<float>& cells) {
    cpu_.for_ranges(rules.height, 8, [&](int begin, int end) {
      for (int y{begin}; y < end; ++y) apply_rules(rules.row(y), rules.width, cells.row(y));
    });
  }

  void fuse(std::span<const HeldCell> held) {
    const ScopedTimer timer{times_.project};
    stereogrid::fuse(back_end_, frame_.other_grids, vehicle_cells_, config_.fusion, result_->observed.view());
    stereogrid::fuse(back_end_, frame_.other_grids, window_cells_, config_.fusion, space_.observed_world.view());
    for (const HeldCell& one : held) {
      float& cell{space_.observed_world.data()[one.cell]};
      cell = std::max(cell, one.occupancy);
    }
  }

  void resample() {
    const KnownKinds kinds{&space_.filtered.kinds, is_reused() ? &space_.part_kinds : nullptr};
    const Pose2& pose{frame_.world_from_vehicle};
    if constexpr (std::is_same_v<BackEndType, Reference>) return stereogrid::resample(pose, *result_);
    cpu_.for_ranges(result_->vehicle.geometry.ny, 8,
                    [&](int begin, int end) { resample_rows(pose, begin, end, kinds, *result_); });
  }

  [[nodiscard]] bool is_reused() const { return result_ == options_.reused; }

  // Kinds of the blocks that the result's layers now have.
  void keep_block_kinds() {
    if (is_reused()) space_.block_kinds = space_.filtered.kinds;
  }

  void clear_masked() {
    if (mask_ == nullptr || mask_->empty()) return;
    cpu_.for_ranges(mask_->end_row() - mask_->first_row(), 8,
                    [this](int begin, int end) { mask_->clear(begin, end, space_.matches); });
  }

  View<const std::uint8_t> aligned(View<const std::uint8_t> right) {
    if (rows_->is_identity()) return right;
    align_rows(back_end_, right, rows_->offsets(), space_.aligned_right.view());
    return space_.aligned_right.view();
  }

  [[nodiscard]] bool counts_rays() const { return config_.projection.model == ProjectionModel::rays; }

  void project_to(const GridInVehicle& grid, Image<float>& cells) {
    const BinGeometry bins{rig_};
    if (counts_rays()) return project_rays(back_end_, space_.rays, bins, grid, cells.view());
    const View<const float> occupancy{std::as_const(result_->stages.occupancy_smooth).view()};
    stereogrid::project(back_end_, occupancy, bins, grid, space_.projection, cells.view());
  }

  Config config_;
  Rig rig_;
  StagesOptions options_;
  Cpu& cpu_;
  BackEndType& back_end_;
  HostSpace space_;
  const PixelMask* mask_{nullptr};

  // level images of a frame
  LevelFrame frame_;
  FrameResult* result_{nullptr};
  GridGeometry window_;
  GridInVehicle vehicle_cells_{};  ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells_{};   ///< the window in the vehicle frame
  TerrainRules rules_;
  Ground previous_;
  const RowAlignment* rows_{nullptr};
  Ground ground_;
  bool is_lost_{false};
  StageTimes times_;
};

}  // namespace stereogrid
