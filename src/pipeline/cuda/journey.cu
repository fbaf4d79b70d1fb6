// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda/journey.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

/// Frames after which a road that was not found is searched again; as on the CPU.
constexpr int pause_frames{3};

// A DeviceError each, since `auto` then takes the CPU.
const Config& checked(const Config& config) {
  const auto require = [](bool can, const char* setting) {
    if (!can) throw DeviceError{std::string{setting} + " can be had on the CPU only."};
  };
  require(config.filter.model != FilterModel::particles, "filter.model=particles");
  require(config.u_disparity.bins_per_px == 1, "u_disparity.bins_per_px above 1");
  require(!config.projection.interpolate_far, "projection.interpolate_far");
  return config;
}

GridInVehicle placed(const GridGeometry& grid, const Pose2& to_from_grid) {
  return {grid, to_from_grid.x_m, to_from_grid.y_m, std::cos(to_from_grid.yaw_rad), std::sin(to_from_grid.yaw_rad)};
}

template <class T>
void put(View<const T> image, T* pinned) {
  for (int v{0}; v < image.height; ++v) std::copy_n(image.row(v), image.width, pinned + v * image.width);
}

}  // namespace

JourneyOnCuda::JourneyOnCuda(const Config& config, const Rig& rig)
    : config_{checked(config)},
      rig_{rig},
      ground_{calibrated_ground(rig, config.ground)},
      trust_{rig, config.ground},
      alignment_{rig},
      window_{vehicle_grid_of(config.grid)},
      vehicle_grid_{vehicle_grid_of(config.grid)},
      filter_tables_{config.filter},
      scene_flow_{rig},
      velocity_evidence_{window_.cells(), filter_tables_.axis_mps.back()},
      tracker_{config.tracking},
      matches_{rig.width_px, rig.height_px},
      ground_samples_{rig.width_px, rig.height_px},
      clusters_{window_.cells(), window_.cells(), scene_flow_.points_reserved()},
      host_{rig, vehicle_grid_, window_.cells()},
      device_{cuda_, config, rig, vehicle_grid_, window_.cells(), filter_tables_} {}

MemoryUse JourneyOnCuda::memory_use() const {
  return {sizeof *this + held_.pinned +
              held_bytes_of(alignment_, trust_, filter_tables_, scene_flow_, velocity_evidence_, tracker_, matches_,
                            ground_samples_, clusters_),
          held_.device};
}

void JourneyOnCuda::run(const JourneyInput& input, FrameResult& result) {
  const Ground expected{predicted(rig_, config_.ground, ground_, input.dt_s)};
  take(input);
  expect(expected);
  if (is_first_) find_first_ground(input, expected);
  doubt_ = Doubt::none;
  match_frame();
  follow_points(input);
  make_grids();
  times_.wait_for(StreamTimes::answered);
  if (!is_first_) {
    scatter_lattice();
    measure_rows(input, expected);
    if (is_answered_lost() && search_if_lost()) {
      match_frame();
      make_grids();
    }
  }
  cuda_.synchronize();
  judge(input, expected);
  finish(input, result);
}

// As JourneyMemory::forget.
void JourneyOnCuda::forget() {
  ground_ = calibrated_ground(rig_, config_.ground);
  frames_to_search_ = 0;
  is_first_ = true;
  alignment_ = RowAlignment{rig_};
  trust_ = FrameTrust{rig_, config_.ground};
  scene_flow_ = SceneFlow{rig_};
  tracker_.forget();
}

// Where the frame cannot be relied on, its grids are made again.
void JourneyOnCuda::judge(const JourneyInput& input, const Ground& expected) {
  scatter_lattice();
  ground_ = host_.answer.data()->ground;
  doubt_ = trust_.judge({input.left, input.right, input.disparity, matches_}, ground_, input.dt_s);
  if (doubt_ == Doubt::none) return;
  if (config_.ground.estimate) ground_ = expected;  // a plane through wrong matches would mislead the next frame
  scene_flow_.clear();
  *host_.evidence_count.data() = 0;
  make_grids();
  cuda_.synchronize();
}

// Everything that changes from frame to frame, to where graphs look for it.
void JourneyOnCuda::take(const JourneyInput& input) {
  is_given_ = !input.disparity.empty();
  put(input.left, host_.left.data());
  is_given_ ? put(input.disparity, host_.given.data()) : put(input.right, host_.right.data());
  if (!input.other_grids.empty() || had_other_grids_) device_.other_grids.take(cuda_, input.other_grids);
  had_other_grids_ = !input.other_grids.empty();

  const GridGeometry window{window_.at(input.world_from_vehicle)};
  if (is_first_) window_before_ = window;
  FrameOnDevice& frame{*host_.frame.data()};
  frame.dt_s = input.dt_s;
  frame.vehicle_cells = placed(vehicle_grid_, {});
  frame.window_cells = placed(window, inverse(input.world_from_vehicle));
  frame.vehicle_in_world = placed(vehicle_grid_, input.world_from_vehicle);
  frame.window = window;
  frame.motion = filter_motion({config_.filter, filter_tables_, window, input.dt_s}, window_before_);
  window_before_ = window;
}

// The device must not be reading `frame`.
void JourneyOnCuda::expect(const Ground& expected) {
  FrameOnDevice& frame{*host_.frame.data()};
  frame.plane = road_plane(rig_, expected);
  frame.expected = expected;
  frame.previous = ground_;
  frame.rows = {alignment_.offsets(), alignment_.is_identity() ? 1 : 0};
}

// The first frame is matched on the calibration's plane, once more where the rows turn out to be off, and then searched
// for the road.
void JourneyOnCuda::find_first_ground(const JourneyInput& input, const Ground& expected) {
  match_frame();
  fetch_matches();
  measure_rows(input, expected);
  if (!alignment_.is_identity()) {
    expect(expected);
    match_frame();
    fetch_matches();
    measure_rows(input, expected);
  }
  search_if_lost();
}

bool JourneyOnCuda::is_answered_lost() const {
  return host_.answer.data()->is_lost != 0;
}

// True: another plane is expected now, and the frame is to be matched again.
bool JourneyOnCuda::search_if_lost() {
  if (!config_.ground.estimate) return false;
  if (frames_to_search_ > 0 && --frames_to_search_ > 0) return false;
  cuda_.synchronize();
  // a plane far off would have split the wrong pixels away
  if (is_given_) leave_whole(cuda_, device_.given.view(), config_.matching, device_.matches);
  fetch_matches();
  const Ground found{
      search_ground(rig_, config_.ground, matches_.obstacle.view(), matches_.road.view(), ground_, ground_samples_)};
  if (found.estimated) {
    ground_ = found;
  } else {
    frames_to_search_ = pause_frames;
  }
  if (!found.estimated && !is_given_) return false;
  expect(ground_);
  return true;
}

void JourneyOnCuda::measure_rows(const JourneyInput& input, const Ground& ground) {
  if (!config_.matching.align_rows || is_given_) return;
  alignment_.update(input.left, input.right, matches_, road_plane(rig_, ground));
}

FlowFrame JourneyOnCuda::flow_frame(const JourneyInput& input) const {
  return {input.left, input.right, alignment_.offsets(), input.world_from_vehicle, input.dt_s};
}

namespace {

// On the host there is nobody else.
constexpr auto for_ranges = [](int count, const auto& work) { work(0, count); };

}  // namespace

// While the device matches.
void JourneyOnCuda::follow_points(const JourneyInput& input) {
  Stopwatch watch;
  *host_.evidence_count.data() = 0;
  if (flows()) {
    scene_flow_.follow(flow_frame(input), for_ranges);
    const std::vector<VelocityEvidence>& evidence{
        velocity_evidence_.gather(scene_flow_.vectors(), host_.frame.data()->window)};
    std::copy(evidence.begin(), evidence.end(), host_.evidence.data());
    *host_.evidence_count.data() = static_cast<int>(evidence.size());
  } else {
    scene_flow_.clear();
  }
  flow_ms_ = watch.lap();
}

void JourneyOnCuda::match_frame() {
  do_or_repeat(match_graphs_[is_given_ ? 1 : 0], [&] { record_match(); });
  times_.mark(cuda_, StreamTimes::answered);
}

void JourneyOnCuda::make_grids() {
  if (is_first_) reset(cuda_, device_.filter, &device_.frame.data()->motion, device_.states[1 - now_]);
  do_or_repeat(doubt_ == Doubt::none ? grid_graphs_[now_] : blank_graphs_[now_], [&] { record_grids(); });
}

// The first time without a graph: what the driver loads at a kernel's first launch does not belong into a recording.
void JourneyOnCuda::do_or_repeat(Graph& graph, const std::function<void()>& work) {
  if (!graph.empty()) return graph.launch(cuda_);
  work();
  graph.capture(cuda_, work);
}

void JourneyOnCuda::record_match() {
  times_.mark(cuda_, StreamTimes::start);
  device_.upload_frame(cuda_, host_, is_given_);
  times_.mark(cuda_, StreamTimes::uploaded);
  const FrameOnDevice* frame{device_.frame.data()};
  FrameFromDevice* answer{device_.answer.data()};
  DeviceMatches& matches{device_.matches};
  if (is_given_) {
    split(cuda_, device_.given.view(), rig_, &frame->expected, config_.matching, matches);
  } else {
    align_rows(cuda_, device_.right.view(), &frame->rows, device_.aligned.view());
    match(cuda_, device_.left.view(), device_.aligned.view(), &frame->plane, config_.matching, device_.matching,
          matches);
  }
  times_.mark(cuda_, StreamTimes::matched);
  estimate_ground(cuda_, rig_, config_.ground, matches.obstacle.view(), matches.road.view(), &frame->previous,
                  &frame->dt_s, device_.ground, &answer->ground, &answer->is_lost);
  // splitting is cheap, and the plane is better now
  if (is_given_) split(cuda_, device_.given.view(), rig_, &answer->ground, config_.matching, matches);
  device_.fetch_answer(cuda_, host_);
  times_.mark(cuda_, StreamTimes::ground_known);
}

void JourneyOnCuda::project_grids() {
  const FrameOnDevice* frame{device_.frame.data()};
  const MatchViews matches{std::as_const(device_.matches.obstacle).view(), std::as_const(device_.matches.road).view(),
                           std::as_const(device_.matches.confidence).view()};
  count(cuda_, matches, rig_, &device_.answer.data()->ground, device_.u_disparity);
  times_.mark(cuda_, StreamTimes::counted);
  const View<const float, Device> occupancy{std::as_const(device_.u_disparity.occupancy_smooth).view()};
  const auto project_to = [&](const GridInVehicle* grid, DeviceImage<float>& cells) {
    project(cuda_, occupancy, BinGeometry{rig_}, grid, config_.projection.footprint, device_.projection, cells.view());
  };
  find_largest(cuda_, occupancy, device_.projection);
  project_to(&frame->vehicle_cells, device_.observed);
  project_to(&frame->window_cells, device_.observed_window);
}

void JourneyOnCuda::record_grids() {
  const FrameOnDevice* frame{device_.frame.data()};
  if (doubt_ == Doubt::none) {
    project_grids();
  } else {
    times_.mark(cuda_, StreamTimes::counted);
    device_.observe_nothing(cuda_);
  }
  fuse(cuda_, device_.other_grids, &frame->vehicle_cells, config_.fusion, device_.observed.view());
  fuse(cuda_, device_.other_grids, &frame->window_cells, config_.fusion, device_.observed_window.view());
  times_.mark(cuda_, StreamTimes::projected);
  filter(cuda_, device_.filter, &frame->motion, std::as_const(device_.observed_window).view(), device_.states[1 - now_],
         device_.states[now_], device_.world);
  if (config_.filter.model == FilterModel::joint) {
    weigh_velocities(cuda_, device_.filter, host_.evidence.data(), host_.evidence_count.data(), device_.states[now_],
                     device_.world);
  }
  resample(cuda_, device_.world, &frame->window, &frame->vehicle_in_world, device_.vehicle);
  times_.mark(cuda_, StreamTimes::filtered);
  device_.fetch_grids(cuda_, host_);
  times_.mark(cuda_, StreamTimes::fetched);
}

void JourneyOnCuda::fetch_matches() {
  download(cuda_, device_.matches.obstacle.data(), matches_.obstacle.size(), matches_.obstacle.data());
  download(cuda_, device_.matches.road.data(), matches_.road.size(), matches_.road.data());
  cuda_.synchronize();
}

// RowAlignment and SceneFlow read no other pixels.
void JourneyOnCuda::scatter_lattice() {
  const MatchLattice lattice{rig_.width_px, rig_.height_px};
  const float* disparity{host_.lattice.data()};
  for (int j{0}; j < lattice.down; ++j) {
    for (int i{0}; i < lattice.across; ++i, ++disparity) {
      const int u{MatchLattice::first_u + i * MatchLattice::step_u};
      const int v{MatchLattice::first_v + j * MatchLattice::step_v};
      matches_.obstacle(u, v) = std::max(*disparity, 0.0f);
      matches_.road(u, v) = std::max(-*disparity, 0.0f);
    }
  }
}

void JourneyOnCuda::finish(const JourneyInput& input, FrameResult& result) {
  Stopwatch watch;
  const FrameFromDevice& answer{*host_.answer.data()};
  const double pixels{static_cast<double>(matches_.obstacle.size())};
  result.ground = ground_;
  tell(doubt_, result);
  result.obstacle_density = answer.matched[0] / pixels;
  result.road_density = answer.matched[1] / pixels;
  result.world.geometry = host_.frame.data()->window;
  PackedGrids{vehicle_grid_, window_.cells()}.copy_to(host_.grids.data(), result);
  if (are_stages_wanted_) {
    device_.fetch_stages(cuda_, result.stages);
    if (doubt_ != Doubt::none) leave_unknown(result.stages);
  }
  result.timing_ms = times_.stages();
  result.timing_ms.filter += watch.lap();

  find_clusters(result.world, config_.tracking, clusters_);
  // remembered, not seen: tracks coast
  if (doubt_ != Doubt::none && input.other_grids.empty()) clusters_.clusters.clear();
  measure_velocities(scene_flow_.vectors(), result.world.geometry, clusters_);
  tracker_.update(result.world, clusters_.clusters, input.dt_s);
  tracker_.report(input.world_from_vehicle, result.obstacles);
  result.timing_ms.track = watch.lap();
  if (flows() && doubt_ == Doubt::none) {
    scene_flow_.add_points(flow_frame(input), matches_, for_ranges);
  }
  result.timing_ms.flow = flow_ms_ + watch.lap();
  is_first_ = false;
  now_ = 1 - now_;
}

template <class State>
void JourneyOnCuda::exchange(State& state) {
  state(ground_, frames_to_search_, is_first_, alignment_, trust_, window_before_, scene_flow_, tracker_);
}

void JourneyOnCuda::save(StateWriter& state) {
  exchange(state);
  std::vector<float> numbers;
  device_.states[1 - now_].for_each_array([&](float* on_device, std::size_t size) {
    numbers.resize(size);
    download(cuda_, on_device, size, numbers.data());
    cuda_.synchronize();
    state(numbers);
  });
}

void JourneyOnCuda::load(StateReader& state) {
  exchange(state);
  std::vector<float> numbers;
  device_.states[1 - now_].for_each_array([&](float* on_device, std::size_t size) {
    state(numbers);
    state.require(numbers.size() == size);
    if (numbers.size() != size) return;
    upload(cuda_, numbers.data(), size, on_device);
    cuda_.synchronize();
  });
}

}  // namespace stereogrid
