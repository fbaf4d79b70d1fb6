// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <type_traits>

#include "filter/filter.hpp"
#include "fusion/fusion.hpp"
#include "ground/ground.hpp"
#include "matching/given.hpp"
#include "matching/matching.hpp"
#include "pipeline/host_space.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/stopwatch.hpp"
#include "projection/projection.hpp"
#include "rays/rays.hpp"
#include "u_disparity/u_disparity.hpp"

namespace stereogrid {

/// The stages on a back end that works in the host's memory: Cpu or Reference.
template <class BackEndType>
class HostStages final : public Stages {
 public:
  template <class... BackEndArguments>
  HostStages(const Config& config, const Rig& level_rig, BackEndArguments... arguments)
      : config_{config},
        rig_{level_rig},
        back_end_{arguments...},
        space_{config, rig_, vehicle_grid_of(config.grid), threads()} {
    make_room(back_end_, config.matching, space_.matching);
  }

  void begin(const LevelFrame& frame, const GridGeometry& window, bool is_first, FrameResult& result) override {
    frame_ = frame;
    result_ = &result;
    window_ = window;
    vehicle_cells_ = grid_in_vehicle(result.vehicle.geometry, {});
    window_cells_ = grid_in_vehicle(window, inverse(frame.world_from_vehicle));
    times_ = {};
    velocities_ = {};
    held_ = {};
    std::swap(space_.filtered, space_.filtered_before);
    if (is_first) reset(space_.filtered_before, config_.filter, window);
  }

  void expect(const Ground& expected, const Ground& previous, const RowAlignment& rows) override {
    expected_ = expected;
    previous_ = previous;
    rows_ = &rows;
  }

  void take_velocities(std::span<const VelocityEvidence> evidence) override { velocities_ = evidence; }

  void hold(std::span<const HeldCell> cells) override { held_ = cells; }

  void match() override {
    const Timer timer{times_.match};
    match_on(expected_);
  }

  void estimate_ground() override {
    const Timer timer{times_.ground};
    HostSpace& s{space_};
    is_lost_ = stereogrid::is_lost(rig_, config_.ground, s.matches.obstacle.view(), s.matches.road.view(), previous_,
                                   s.ground_samples);
    ground_ = stereogrid::estimate_ground(rig_, config_.ground, s.matches.road.view(), previous_, frame_.dt_s,
                                          s.ground_samples);
    if (frame_.is_given()) match_on(ground_);  // splitting is cheap, and the plane is better now
  }

  void count() override {
    const Timer timer{times_.count};
    if (counts_rays()) count_rays(back_end_, space_.matches, rig_, ground_, config_.u_disparity, space_.rays);
    if (counts_rays() && !are_stages_wanted_) return;
    stereogrid::count(back_end_, space_.matches, rig_, ground_, space_.u_disparity_tables, space_.u_disparity,
                      result_->stages);
  }

  void project() override {
    const Timer timer{times_.project};
    project_to(vehicle_cells_, result_->observed);
    project_to(window_cells_, space_.observed_world);
  }

  void observe_nothing() override {
    result_->observed.fill(0.5f);
    space_.observed_world.fill(0.5f);
  }

  void fuse() override {
    const Timer timer{times_.project};
    stereogrid::fuse(back_end_, frame_.other_grids, vehicle_cells_, config_.fusion, result_->observed.view());
    stereogrid::fuse(back_end_, frame_.other_grids, window_cells_, config_.fusion, space_.observed_world.view());
    for (const HeldCell& held : held_) {
      float& cell{space_.observed_world.data()[held.cell]};
      cell = std::max(cell, held.occupancy);
    }
  }

  void filter() override {
    const Timer timer{times_.filter};
    HostSpace& s{space_};
    const std::vector<BlockKind>* const kinds_before{is_kept() ? &s.block_kinds : nullptr};
    stereogrid::filter(back_end_, {config_.filter, s.filter_tables, window_, frame_.dt_s, frame_.view, kinds_before},
                       s.observed_world.view(), s.filtered_before, s.filtered, result_->world);
    take_block_kinds();
  }

  void weigh_velocities() override {
    const Timer timer{times_.filter};
    stereogrid::weigh_velocities(back_end_, velocities_, space_.filter_tables, space_.weighing, space_.filtered,
                                 result_->world);
    take_block_kinds();
  }

  void resample() override {
    const Timer timer{times_.filter};
    const KnownKinds kinds{&space_.filtered.kinds, is_kept() ? &space_.part_kinds : nullptr};
    const Pose2& pose{frame_.world_from_vehicle};
    if constexpr (std::is_same_v<BackEndType, Reference>) return stereogrid::resample(pose, *result_);
    const auto work = [&](int begin, int end) { resample_rows(pose, begin, end, kinds, *result_); };
    for_ranges(result_->vehicle.geometry.ny, std::cref(work));
  }

  Ground ground() override { return ground_; }
  bool is_lost() override { return is_lost_; }
  const Matches& matches_on_lattice() override { return space_.matches; }
  const Matches& unsplit_matches() override {
    if (frame_.is_given()) {
      leave_whole(frame_.disparity, config_.matching, space_.matches);
      clear_masked();
    }
    return space_.matches;
  }

  View<const float> obstacle_disparity() override { return space_.matches.obstacle.view(); }
  void finish() override {
    const Matches& matches{space_.matches};
    const auto obstacles = [&] {
      result_->obstacle_density = share_matched(matches.obstacle);
      if (are_stages_wanted_) result_->stages.obstacle_disparity = matches.obstacle;
    };
    const auto road = [&] {
      result_->road_density = share_matched(matches.road);
      if (are_stages_wanted_) result_->stages.road_disparity = matches.road;
    };
    together(std::cref(obstacles), std::cref(road));
    if (are_stages_wanted_) result_->stages.match_confidence = matches.confidence;
    result_->timing_ms = times_;
  }

  [[nodiscard]] int threads() const override {
    if constexpr (requires { back_end_.threads(); }) return back_end_.threads();
    return 1;
  }

  void for_ranges(int count, const std::function<void(int, int)>& work) override {
    if constexpr (requires { back_end_.threads(); }) {
      back_end_.for_ranges(count, 8, work);
    } else {
      work(0, count);
    }
  }

  void together(const std::function<void()>& first, const std::function<void()>& second) override {
    if constexpr (requires { back_end_.threads(); }) {
      back_end_.together(first, second);
    } else {
      Stages::together(first, second);
    }
  }

  void fetch_stages(bool wanted) override { are_stages_wanted_ = wanted; }
  void take_mask(const PixelMask& mask) override { mask_ = &mask; }
  void keep(const FrameResult& result) override { kept_ = &result; }
  [[nodiscard]] MemoryUse memory_use() const override { return {sizeof *this + space_.held_bytes(), 0}; }
  void save(StateWriter& state) override { state(space_.filtered); }
  void load(StateReader& state) override { state(space_.filtered); }

  void make_room_for_predictions() override {
    if (!space_.prediction) space_.prediction = std::make_unique<PredictionSpace>(space_.filtered);
  }

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
  /// Adds the milliseconds that it lives.
  class Timer {
   public:
    explicit Timer(double& sum_ms) : sum_ms_{sum_ms} {}
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;
    ~Timer() { sum_ms_ += watch_.lap(); }

   private:
    double& sum_ms_;
    Stopwatch watch_;
  };

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

  [[nodiscard]] bool is_kept() const { return result_ == kept_; }

  // What the filter knows of its state's blocks it has done to the layers.
  void take_block_kinds() {
    if (is_kept()) space_.block_kinds = space_.filtered.kinds;
  }

  void clear_masked() {
    if (mask_ == nullptr || mask_->empty()) return;
    for_ranges(mask_->end_row() - mask_->first_row(),
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
  BackEndType back_end_;
  HostSpace space_;
  bool are_stages_wanted_{true};
  const PixelMask* mask_{nullptr};
  const FrameResult* kept_{nullptr};

  // of a frame
  LevelFrame frame_;
  FrameResult* result_{nullptr};
  GridGeometry window_;
  GridInVehicle vehicle_cells_{};  ///< the vehicle's grid in the vehicle frame
  GridInVehicle window_cells_{};   ///< the window in the vehicle frame
  Ground expected_;
  Ground previous_;
  const RowAlignment* rows_{nullptr};
  std::span<const VelocityEvidence> velocities_;
  std::span<const HeldCell> held_;
  Ground ground_;
  bool is_lost_{false};
  StageTimes times_;
};

}  // namespace stereogrid
