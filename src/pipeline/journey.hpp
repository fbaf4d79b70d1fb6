// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "filter/filter.hpp"
#include "fusion/fusion.hpp"
#include "ground/ground.hpp"
#include "ground/trust.hpp"
#include "images/row_alignment/row_alignment.hpp"
#include "matching/given.hpp"
#include "matching/matching.hpp"
#include "motion/scene_flow.hpp"
#include "motion/velocity_evidence.hpp"
#include "obstacles/tracking.hpp"
#include "pipeline/saved_state.hpp"
#include "projection/calibration.hpp"
#include "projection/projection.hpp"
#include "stereogrid/pipeline.hpp"
#include "u_disparity/u_disparity.hpp"

namespace stereogrid {

/// A frame as the stages take it: level images that fit the rig.
struct JourneyInput {
  View<const std::uint8_t> left;
  View<const std::uint8_t> right;
  View<const float> disparity;  ///< given instead of the right image; empty: match
  Pose2 world_from_vehicle;
  double dt_s{0};
  std::span<const ObservedGrid> other_grids;
};

/// The way of a frame through all stages, on some back end.
class Journey {
 public:
  Journey() = default;
  Journey(const Journey&) = delete;
  Journey& operator=(const Journey&) = delete;
  virtual ~Journey() = default;
  virtual void run(const JourneyInput& input, FrameResult& result) = 0;
  /// The next frame is a first one. Ids of obstacles go on.
  virtual void forget() = 0;
  virtual void start_ids_at(std::int64_t first_id) = 0;
  virtual int threads() = 0;
  [[nodiscard]] virtual MemoryUse memory_use() const = 0;
  /// To be called before predict().
  virtual void make_room_for_predictions() {}
  /// Fills result.predictions after run(); false: this back end cannot.
  virtual bool predict(const Pose2& /*world_from_vehicle*/, FrameResult& /*result*/) { return false; }
  /// What run() remembers between two frames.
  virtual void save(StateWriter& state) = 0;
  virtual void load(StateReader& state) = 0;
  /// Must FrameResult::stages be filled?
  virtual void fetch_stages(bool /*wanted*/) {}
};

std::unique_ptr<Journey> cpu_journey(const Config& config, const Rig& rig, int threads);
std::unique_ptr<Journey> reference_journey(const Config& config, const Rig& rig);

/// The vehicle-frame grid that a configuration asks for.
GridGeometry vehicle_grid_of(const GridConfig& config);

/// A result with all its images allocated.
FrameResult empty_result(const Config& config, const Rig& rig);

/// Rows of the u-disparity images.
int bins_of(const Config& config);

/// Share of the pixels that have a disparity.
double share_matched(const Image<float>& disparity);

std::size_t held_bytes(const GridLayers& layers);
std::size_t held_bytes(const StageImages& stages);
std::size_t held_bytes(const FrameResult& result);

/// Working memory of predictions.
struct Outlook {
  explicit Outlook(const FilterState& now)
      : state{now},
        layers{grid_layers({0, 0, 1, now.occupancy.width(), now.occupancy.height()})},
        nothing{now.occupancy.width(), now.occupancy.height(), 0.5f} {}

  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(state, layers, nothing); }

  FilterState state;
  GridLayers layers;
  Image<float> nothing;  ///< observed
};

/// What the stages hand to each other and keep between frames. Allocated once.
struct JourneyMemory {
  JourneyMemory(const Config& parameters, const Rig& level_rig, const GridGeometry& vehicle_grid, int threads);
  /// As at construction; ids of tracks go on.
  void forget();

  template <class State>
  void exchange(State& state) {
    state(ground, frames_to_search, is_first, alignment, trust, filtered, scene_flow, tracker);
  }

  [[nodiscard]] std::size_t held_bytes() const;

  Config config;
  Rig rig;
  Ground ground;  ///< of the last frame
  FrameTrust trust;
  int frames_to_search{0};
  bool is_first{true};
  RowAlignment alignment;
  Image<std::uint8_t> aligned_right;
  Matches matches;
  MatchingSpace matching;
  GroundSpace ground_samples;
  UDisparityTables u_disparity_tables;
  UDisparitySpace u_disparity;
  ProjectionSpace projection;
  Calibration calibration;
  Window window;
  FilterTables filter_tables;
  Image<float> observed_world;
  FilterState filtered;
  FilterState filtered_before;
  std::unique_ptr<Outlook> outlook;  ///< once somebody wants predictions
  SceneFlow scene_flow;
  EvidenceMap velocity_evidence;
  WeighingSpace weighing;
  ClusterSpace clusters;
  Tracker tracker;
};

/// Milliseconds since the last call.
class Stopwatch {
 public:
  double lap() {
    const auto now{std::chrono::steady_clock::now()};
    return std::chrono::duration<double, std::milli>(now - std::exchange(last_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point last_{std::chrono::steady_clock::now()};
};

template <class BackEndType>
class JourneyOn final : public Journey {
 public:
  template <class... BackEndArguments>
  JourneyOn(const Config& config, const Rig& rig, const GridGeometry& vehicle_grid, BackEndArguments... arguments)
      : back_end_{arguments...}, memory_{config, rig, vehicle_grid, threads()} {
    make_room(back_end_, config.matching, memory_.matching);
  }

  void run(const JourneyInput& input, FrameResult& result) override {
    Stopwatch watch;
    JourneyMemory& m{memory_};
    const bool flows{m.config.filter.scene_flow && input.disparity.empty()};
    flows ? m.scene_flow.follow(flow_frame(input), for_ranges()) : m.scene_flow.clear();
    result.timing_ms.flow = watch.lap();
    const bool is_reliable{match_and_estimate_ground(input, result, watch)};
    is_reliable ? count(back_end_, m.matches, m.rig, m.ground, m.u_disparity_tables, m.u_disparity, result.stages)
                : leave_unknown(result.stages);
    result.timing_ms.count = watch.lap();

    const GridGeometry window{m.window.at(input.world_from_vehicle)};
    const GridInVehicle vehicle_cells{placed(result.vehicle_grid, {})};
    const GridInVehicle window_cells{placed(window, inverse(input.world_from_vehicle))};
    project_to(vehicle_cells, is_reliable, result, result.observed);
    project_to(window_cells, is_reliable, result, m.observed_world);
    fuse(back_end_, input.other_grids, vehicle_cells, m.config.fusion, result.observed.view());
    fuse(back_end_, input.other_grids, window_cells, m.config.fusion, m.observed_world.view());
    result.timing_ms.project = watch.lap();

    std::swap(m.filtered, m.filtered_before);
    if (m.is_first) reset(m.filtered_before, m.config.filter, window);
    filter(back_end_, {m.config.filter, m.filter_tables, window, input.dt_s}, m.observed_world.view(),
           m.filtered_before, m.filtered, result.world);
    weigh_velocities_by_flow(result.world);
    for_ranges()(result.vehicle_grid.ny,
                 [&](int begin, int end) { resample_rows(input.world_from_vehicle, begin, end, result); });
    result.timing_ms.filter = watch.lap();

    find_clusters(result.world, m.config.tracking, m.clusters);
    if (!is_reliable && input.other_grids.empty()) m.clusters.clusters.clear();  // remembered, not seen: tracks coast
    measure_velocities(m.scene_flow.vectors(), result.world.geometry, m.clusters);
    m.tracker.update(result.world, m.clusters.clusters, input.dt_s);
    m.tracker.report(input.world_from_vehicle, result.obstacles);
    result.timing_ms.track = watch.lap();
    if (flows && is_reliable) m.scene_flow.add_points(flow_frame(input), m.matches, for_ranges());
    result.timing_ms.flow += watch.lap();
    m.is_first = false;
  }

  [[nodiscard]] MemoryUse memory_use() const override { return {sizeof *this + memory_.held_bytes(), 0}; }

  void make_room_for_predictions() override {
    if (!memory_.outlook) memory_.outlook = std::make_unique<Outlook>(memory_.filtered);
  }

  // A prediction is a step in which nothing is seen.
  bool predict(const Pose2& world_from_vehicle, FrameResult& result) override {
    JourneyMemory& m{memory_};
    Outlook& ahead{*m.outlook};
    for (Prediction& prediction : result.predictions) {
      filter(back_end_, {m.config.filter, m.filter_tables, result.world.geometry, prediction.horizon_s},
             ahead.nothing.view(), m.filtered, ahead.state, ahead.layers);
      prediction.world_occupancy = ahead.layers.occupancy;
      resample_occupancy(ahead.layers, world_from_vehicle, result.vehicle_grid, prediction.occupancy);
    }
    return true;
  }

  void forget() override { memory_.forget(); }

  void start_ids_at(std::int64_t first_id) override { memory_.tracker.start_ids_at(first_id); }

  void save(StateWriter& state) override { state(memory_); }
  void load(StateReader& state) override { state(memory_); }

  void fetch_stages(bool wanted) override { are_stages_wanted_ = wanted; }

  int threads() override {
    if constexpr (requires { back_end_.threads(); }) return back_end_.threads();
    return 1;
  }

 private:
  /// Frames after which a road that was not found is searched again.
  static constexpr int pause_frames{3};

  [[nodiscard]] FlowFrame flow_frame(const JourneyInput& input) const {
    return {input.left, input.right, memory_.alignment.offsets(), input.world_from_vehicle, input.dt_s};
  }

  /// Calls work(begin, end) on parts of [0, count).
  auto for_ranges() {
    return [this](int count, const auto& work) {
      if constexpr (requires { back_end_.threads(); }) {
        back_end_.for_ranges(count, 8, work);
      } else {
        work(0, count);
      }
    };
  }

  void weigh_velocities_by_flow(GridLayers& world) {
    JourneyMemory& m{memory_};
    if (m.config.filter.model != FilterModel::joint) return;
    weigh_velocities(back_end_, m.velocity_evidence.gather(m.scene_flow.vectors(), world.geometry), m.filter_tables,
                     m.weighing, m.filtered, world);
  }

  void match_on(const JourneyInput& input, const Ground& ground) {
    JourneyMemory& m{memory_};
    if (!input.disparity.empty()) return split(back_end_, input.disparity, m.rig, ground, m.config.matching, m.matches);
    match(back_end_, input.left, aligned(input.right), road_plane(m.rig, ground), m.config.matching, m.matching,
          m.matches);
  }

  View<const std::uint8_t> aligned(View<const std::uint8_t> right) {
    JourneyMemory& m{memory_};
    if (m.alignment.is_identity()) return right;
    align_rows(back_end_, right, m.alignment.offsets(), m.aligned_right.view());
    return m.aligned_right.view();
  }

  // From the matches on the road `ground`.
  void measure_rows(const JourneyInput& input, const Ground& ground) {
    JourneyMemory& m{memory_};
    if (!m.config.matching.align_rows || !input.disparity.empty()) return;
    m.alignment.update(input.left, input.right, m.matches, road_plane(m.rig, ground), for_ranges());
  }

  // The road hypothesis needs a plane before there is any disparity: that of the frame before. At the start, and when
  // the road turns out to lie elsewhere, a plane is searched in what matched, and the frame is matched again. False:
  // the grids must not be built on this.
  bool match_and_estimate_ground(const JourneyInput& input, FrameResult& result, Stopwatch& watch) {
    JourneyMemory& m{memory_};
    const Ground expected{predicted(m.rig, m.config.ground, m.ground, input.dt_s)};
    match_on(input, expected);
    measure_rows(input, expected);
    if (m.is_first && !m.alignment.is_identity()) {
      match_on(input, expected);
      measure_rows(input, expected);
    }
    result.timing_ms.match = watch.lap();
    const bool again{search_if_lost(input)};
    result.timing_ms.ground = watch.lap();
    if (again) {
      match_on(input, m.ground);
      result.timing_ms.match += watch.lap();
    }
    m.ground = estimate_ground(m.rig, m.config.ground, m.matches.road.view(), m.ground, input.dt_s, m.ground_samples);
    result.timing_ms.ground += watch.lap();
    if (!input.disparity.empty()) match_on(input, m.ground);  // splitting is cheap, and the plane is better now
    result.obstacle_density = share_matched(m.matches.obstacle);
    result.road_density = share_matched(m.matches.road);
    if (are_stages_wanted_) {
      result.stages.obstacle_disparity = m.matches.obstacle;
      result.stages.road_disparity = m.matches.road;
      result.stages.match_confidence = m.matches.confidence;
    }
    result.timing_ms.match += watch.lap();
    return judge(input, expected, result);
  }

  bool judge(const JourneyInput& input, const Ground& expected, FrameResult& result) {
    JourneyMemory& m{memory_};
    const Doubt doubt{m.trust.judge({input.left, input.right, input.disparity, m.matches}, m.ground, input.dt_s)};
    if (doubt != Doubt::none) {
      if (m.config.ground.estimate) m.ground = expected;  // a plane through wrong matches would mislead the next frame
      m.scene_flow.clear();
    }
    result.ground = m.ground;
    tell(doubt, result);
    return doubt == Doubt::none;
  }

  // True: to be matched again. After a search that found nothing there is a pause, as it would find nothing again.
  bool search_if_lost(const JourneyInput& input) {
    JourneyMemory& m{memory_};
    if (!m.config.ground.estimate) return false;
    if (m.frames_to_search > 0 && --m.frames_to_search > 0) return false;
    const auto obstacle{m.matches.obstacle.view()};
    const auto road{m.matches.road.view()};
    if (!m.is_first && !is_lost(m.rig, m.config.ground, obstacle, road, m.ground, m.ground_samples)) return false;
    const bool is_given{!input.disparity.empty()};
    // a plane far off would have split the wrong pixels away
    if (is_given) leave_whole(input.disparity, m.config.matching, m.matches);
    const Ground found{search_ground(m.rig, m.config.ground, obstacle, road, m.ground, m.ground_samples)};
    if (found.estimated) {
      m.ground = found;
    } else {
      m.frames_to_search = pause_frames;
    }
    return found.estimated || is_given;
  }

  static GridInVehicle placed(const GridGeometry& grid, const Pose2& vehicle_from_grid) {
    return {grid, vehicle_from_grid.x_m, vehicle_from_grid.y_m, std::cos(vehicle_from_grid.yaw_rad),
            std::sin(vehicle_from_grid.yaw_rad)};
  }

  void project_to(const GridInVehicle& grid, bool is_reliable, const FrameResult& result, Image<float>& cells) {
    if (!is_reliable) return cells.fill(0.5f);
    const BinGeometry bins{memory_.rig, memory_.config.u_disparity.bins_per_px};
    project(back_end_, result.stages.occupancy_smooth.view(), bins, grid, memory_.config.projection.footprint,
            memory_.projection, cells.view());
    if (memory_.config.projection.interpolate_far) {
      interpolate_far(back_end_, result.stages.occupancy_smooth.view(), bins, grid, cells.view());
    }
    if (memory_.config.projection.calibrate) memory_.calibration.apply(cells.view());
  }

  BackEndType back_end_;
  JourneyMemory memory_;
  bool are_stages_wanted_{true};
};

}  // namespace stereogrid
