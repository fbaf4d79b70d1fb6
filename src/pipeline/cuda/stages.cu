// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda/stages.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "images/patch.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"

namespace stereogrid {
namespace {

template <class T>
void put(View<const T> image, T* pinned) {
  for (int v{0}; v < image.height; ++v) std::copy_n(image.row(v), image.width, pinned + v * image.width);
}

}  // namespace

CudaStages::CudaStages(const Config& config, const Rig& level_rig, int device, const StagesOptions& options)
    : Stages{options.mask, true},
      config_{config},
      rig_{level_rig},
      cuda_{device},
      options_{options},
      vehicle_grid_{vehicle_grid_of(config.grid)},
      window_cells_{Window{vehicle_grid_}.cells()},
      filter_tables_{config.filter},
      device_{cuda_, config, rig_, vehicle_grid_, window_cells_, filter_tables_},
      host_{rig_, vehicle_grid_, window_cells_, device_.rays.relief.size()},
      matches_{rig_.width_px, rig_.height_px},
      host_matches_{matches_,
                    {host_.obstacle(), rig_.width_px, rig_.height_px, rig_.width_px},
                    {host_.road(), rig_.width_px, rig_.height_px, rig_.width_px}} {
  set_memory_use({sizeof *this + held_.pinned + memory_bytes_of(filter_tables_, matches_), held_.device});
  load_mask();
  cuda_.load([this] { load_kernels(); });
}

// An exception may have ended a frame whose work the device has not finished.
CudaStages::~CudaStages() {
  cudaStreamSynchronize(cuda_.stream());
}

// Loads all kernels that a frame may need: external disparities and grids of other sources may come later.
void CudaStages::load_kernels() {
  for (const bool is_external : {true, false}) {
    is_external_ = is_external;
    enqueue_match();
  }
  split_surfaces();
  has_other_grids_ = true;
  for (const bool is_usable : {false, true}) enqueue_observation(is_usable);
  has_other_grids_ = false;
  reset(cuda_, device_.filter, &device_.frame()->motion, device_.states[now_]);
  enqueue_filter();
}

void CudaStages::load_mask() {
  if (mask().empty()) return;
  const View<const std::uint8_t> masked{mask().view()};
  upload(cuda_, masked.data, device_.masked.size(), device_.masked.data());
  synchronize();
}

void CudaStages::set_mask(PixelMask mask) {
  cuda_.use();
  if (is_at_work_) synchronize();
  const PixelMask& before{this->mask()};
  const bool has_same_rows{mask.empty() == before.empty() && mask.first_row() == before.first_row() &&
                           mask.end_row() == before.end_row()};
  Stages::set_mask(std::move(mask));
  load_mask();
  for (std::size_t i{0}; i < match_graphs_.size() && !has_same_rows; ++i) {
    is_external_ = i == 1;
    if (!match_graphs_[i].empty()) match_graphs_[i].capture(cuda_, [this] { enqueue_match(); });
  }
}

void CudaStages::clear_masked() {
  stereogrid::clear_masked(cuda_, mask(), std::as_const(device_.masked).view(), device_.matches);
}

void CudaStages::synchronize() {
  cuda_.synchronize();
  is_at_work_ = false;
}

// Inputs that change from frame to frame are written to where the graphs read them.
void CudaStages::put_frame(const LevelFrame& frame, const FrameGrids& grids) {
  is_external_ = frame.has_external_disparity();
  if (is_external_) {
    put(frame.disparity, host_.given());
  } else {
    put(frame.left, host_.left());
    put(frame.right, host_.right());
  }
  const FrameSet& set{grids.frame};
  has_other_grids_ = !set.other_grids.empty();
  if (has_other_grids_) device_.other_grids.take(cuda_, set.other_grids);

  FrameOnDevice& on_device{host_.frame()};
  on_device.vehicle_cells = grids.vehicle;
  on_device.window_cells = grids.window_cells;
  on_device.seen_vehicle = grids.seen_vehicle;
  on_device.seen_window = grids.seen_window;
  on_device.vehicle_in_world = grid_in_vehicle(vehicle_grid_, set.world_from_vehicle);
  on_device.window = grids.window;
  on_device.motion = filter_motion(
      {config_.filter, filter_tables_, grids.window, set.dt_s, set.views.empty() ? CameraView{} : set.views.front()},
      grids.is_first ? grids.window : window_before_);
}

// Waits, also after an exception, until the device does not read the memory that is written now.
void CudaStages::match(const LevelFrame& frame, const FrameGrids& grids, const RowAlignment& rows,
                       const MatchGround& ground) {
  cuda_.use();
  if (is_at_work_) synchronize();
  if (ground.surface != nullptr) {
    put_ground(ground.plane);
    put_relief(*ground.surface);
    split_surfaces();
    device_.fetch_answer(cuda_, host_);
    times_.mark(cuda_, StreamTimes::answered);
    is_at_work_ = true;
    is_lattice_taken_ = false;
    return;
  }
  put_frame(frame, grids);
  FrameOnDevice& on_device{host_.frame()};
  on_device.plane = road_plane(rig_, ground.plane);
  on_device.ground = ground.plane;
  on_device.rows = {rows.offsets(), rows.is_identity() ? 1 : 0};
  perform(match_graphs_[is_external_ ? 1 : 0], [this] { enqueue_match(); });
  times_.mark(cuda_, StreamTimes::answered);
  is_lattice_taken_ = false;
}

const HostMatches& CudaStages::read() {
  cuda_.use();
  times_.wait_for(StreamTimes::answered);
  if (!is_lattice_taken_) scatter_lattice();
  is_lattice_taken_ = true;
  return host_matches_;
}

void CudaStages::put_ground(const Ground& ground) {
  host_.frame().ground = ground;
  upload(cuda_, &host_.frame().ground, 1, &device_.frame()->ground);
}

void CudaStages::put_relief(const Relief<Host>& relief) {
  put(relief.rows, host_.relief.data());
  upload(cuda_, host_.relief.data(), device_.rays.relief.size(), device_.rays.relief.data());
}

// The kernels read the rules from pinned memory; without GroundModel::terrain they are not launched.
void CudaStages::observe(const FrameGrids&, const Evidence& evidence, FrameResult&) {
  cuda_.use();
  if (is_at_work_) synchronize();
  if (evidence.is_usable) {
    put_ground(evidence.ground);
    if (device_.rays.relief.size() > 0) put_relief(evidence.rules.relief);
    put(evidence.rules.vehicle, host_.vehicle_rules.data());
    put(evidence.rules.window, host_.window_rules.data());
    *host_.blur_px.data() = evidence.blur_px;
  }
  Graph& graph{(evidence.is_usable ? observe_graphs_ : unknown_graphs_)[has_other_grids_ ? 1 : 0]};
  perform(graph, [&] { enqueue_observation(evidence.is_usable); });
}

void CudaStages::filter(const FrameGrids& grids, const FilterEvidence& evidence, FrameResult&) {
  std::copy(evidence.held.begin(), evidence.held.end(), host_.held.data());
  *host_.held_count.data() = static_cast<int>(evidence.held.size());
  std::copy(evidence.velocities.begin(), evidence.velocities.end(), host_.evidence.data());
  *host_.evidence_count.data() = static_cast<int>(evidence.velocities.size());
  if (grids.is_first) reset(cuda_, device_.filter, &device_.frame()->motion, device_.states[1 - now_]);
  perform(filter_graphs_[now_], [this] { enqueue_filter(); });
}

// The first time without a graph: what the driver prepares at a kernel's first launch does not belong into a recording.
template <class Work>
void CudaStages::perform(Graph& graph, const Work& work) {
  is_at_work_ = true;
  if (has_graphs_ && !graph.empty()) return graph.launch(cuda_);
  work();
  if (has_graphs_) graph.capture(cuda_, work);
}

void CudaStages::enqueue_match() {
  times_.mark(cuda_, StreamTimes::start);
  device_.upload_frame(cuda_, host_, is_external_);
  times_.mark(cuda_, StreamTimes::uploaded);
  const FrameOnDevice* frame{device_.frame()};
  if (is_external_) {
    split_given(&frame->ground);
  } else {
    align_rows(cuda_, device_.right.view(), &frame->rows, device_.aligned.view());
    stereogrid::match(cuda_, device_.left.view(), device_.aligned.view(), &frame->plane, config_.matching,
                      device_.matching, device_.matches);
    clear_masked();
  }
  times_.mark(cuda_, StreamTimes::matched);
  device_.fetch_answer(cuda_, host_);
}

void CudaStages::split_given(const Ground* ground) {
  split(cuda_, device_.given.view(), rig_, ground, config_.matching, device_.matches);
  clear_masked();
}

void CudaStages::split_surfaces() {
  stereogrid::split_surfaces(cuda_, device_.given.view(), rig_, &device_.frame()->ground, device_.rays.relief_view(),
                             config_.matching, device_.matches);
  clear_masked();
}

void CudaStages::enqueue_observation(bool is_usable) {
  times_.mark(cuda_, StreamTimes::resumed);
  if (is_usable) {
    count();
    times_.mark(cuda_, StreamTimes::counted);
    project();
  } else {
    times_.mark(cuda_, StreamTimes::counted);
    device_.observe_nothing(cuda_);
  }
  fuse();
  times_.mark(cuda_, StreamTimes::projected);
}

void CudaStages::count() {
  const MatchViews matches{std::as_const(device_.matches.obstacle).view(), std::as_const(device_.matches.road).view()};
  const Ground* ground{&device_.frame()->ground};
  if (counts_rays()) count_rays(cuda_, matches, rig_, ground, config_.u_disparity, device_.rays);
  if (!counts_rays() || options_.stage_images) {
    stereogrid::count(cuda_, matches, rig_, ground, device_.u_disparity);
  }
}

void CudaStages::project() {
  const FrameOnDevice* frame{device_.frame()};
  const View<const float, Device> occupancy{std::as_const(device_.u_disparity.occupancy_smooth).view()};
  const auto project_to = [&](const GridInVehicle* grid, DeviceImage<float>& cells) {
    if (counts_rays())
      return project_rays(cuda_, device_.rays, BinGeometry{rig_}, grid, host_.blur_px.data(), cells.view());
    stereogrid::project(cuda_, occupancy, BinGeometry{rig_}, grid, device_.projection, cells.view());
  };
  if (!counts_rays()) find_largest(cuda_, occupancy, device_.projection);
  project_to(&frame->seen_vehicle, device_.observed);
  project_to(&frame->seen_window, device_.observed_window);
  if (config_.ground.model == GroundModel::plane) return;
  apply_rules(cuda_, host_.vehicle_rules.data(), device_.observed.view());
  apply_rules(cuda_, host_.window_rules.data(), device_.observed_window.view());
}

void CudaStages::fuse() {
  const FrameOnDevice* frame{device_.frame()};
  const auto fuse_on = [&](const GridInVehicle* grid, DeviceImage<float>& cells) {
    stereogrid::fuse(cuda_, device_.other_grids, grid, config_.fusion, cells.view());
  };
  if (!has_other_grids_) return;
  fuse_on(&frame->vehicle_cells, device_.observed);
  fuse_on(&frame->window_cells, device_.observed_window);
}

void CudaStages::enqueue_filter() {
  stereogrid::hold(cuda_, host_.held.data(), host_.held_count.data(), device_.observed_window.view());
  stereogrid::filter(cuda_, device_.filter, &device_.frame()->motion, std::as_const(device_.observed_window).view(),
                     device_.states[1 - now_], device_.states[now_], device_.world);
  if (config_.filter.model == FilterModel::joint) {
    stereogrid::weigh_velocities(cuda_, device_.filter, host_.evidence.data(), host_.evidence_count.data(),
                                 device_.states[now_], device_.world);
  }
  const FrameOnDevice* frame{device_.frame()};
  stereogrid::resample(cuda_, device_.world, &frame->window, &frame->vehicle_in_world, device_.vehicle);
  times_.mark(cuda_, StreamTimes::filtered);
  device_.fetch_grids(cuda_, host_);
  times_.mark(cuda_, StreamTimes::fetched);
}

void CudaStages::scatter_lattice() {
  const MatchLattice lattice{rig_.width_px, rig_.height_px};
  const float* disparity{host_.lattice()};
  for (int j{0}; j < lattice.down; ++j) {
    for (int i{0}; i < lattice.across; ++i, ++disparity) {
      const int u{MatchLattice::first_u + i * MatchLattice::step_u};
      const int v{MatchLattice::first_v + j * MatchLattice::step_v};
      matches_.obstacle(u, v) = std::max(*disparity, 0.0f);
      matches_.road(u, v) = std::max(-*disparity, 0.0f);
    }
  }
}

void CudaStages::publish(const FrameGrids&, FrameResult& result) {
  read();
  synchronize();
  Stopwatch watch;
  result.world.geometry = host_.frame().window;
  PackedGrids{vehicle_grid_, window_cells_}.copy_to(host_.grids.data(), result);
  result.timing_ms = times_.stages();
  result.timing_ms.filter += watch.lap();
  now_ = 1 - now_;
  window_before_ = host_.frame().window;
}

void CudaStages::publish_matches(FrameResult& result) {
  const FrameFromDevice& answer{host_.answer()};
  const double pixels{static_cast<double>(matches_.obstacle.size())};
  MatchedPixels matched{};
  for (const MatchedPixels& part : answer.matched) {
    matched.obstacle += part.obstacle;
    matched.road += part.road;
  }
  result.obstacle_density = matched.obstacle / pixels;
  result.road_density = matched.road / pixels;
  if (!options_.stage_images) return;
  device_.fetch_stages(cuda_, result.stages);
  set_obstacles(std::as_const(result.stages.obstacle_disparity).view(), result.stages);
}

}  // namespace stereogrid
