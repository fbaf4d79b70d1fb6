// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda/stages.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "images/patch.hpp"
#include "pipeline/results.hpp"
#include "pipeline/stages.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

template <class T>
void put(View<const T> image, int begin, int end, T* pinned) {
  for (int v{begin}; v < end; ++v) std::copy_n(image.row(v), image.width, pinned + v * image.width);
}

}  // namespace

CudaStages::CudaStages(const Config& config, const Rig& level_rig, int device, const StagesOptions& options)
    : Stages{options.mask},
      config_{config},
      rig_{level_rig},
      cuda_{device},
      beside_{device},
      options_{options},
      sizes_{vehicle_grid_of(config.grid), options.filters},
      filter_tables_{config.filter},
      device_{cuda_, config, rig_, sizes_, filter_tables_},
      host_{rig_, sizes_, device_.rays.relief.size()},
      columns_{cuda_, rig_, config.u_disparity, config.matching.disparities},
      low_obstacles_{has_terrain() ? rig_ : Rig{}, has_terrain() ? sizes_.window : 0, config.matching.disparities},
      ground_{rig_, has_terrain() ? rings_of(config).capacity() : 0, has_terrain() ? sizes_.vehicle : GridGeometry{},
              has_terrain() ? sizes_.window : 0},
      matches_{rig_.width_px, rig_.height_px} {
  set_memory_use({sizeof *this + held_.pinned + memory_bytes_of(filter_tables_, matches_), held_.device});
  load_mask();
  cuda_.load([this] { beside_.load([this] { load_kernels(); }); });
}

// An exception may have ended a frame whose work the device has not finished.
CudaStages::~CudaStages() {
  cudaStreamSynchronize(beside_.stream());
  cudaStreamSynchronize(cuda_.stream());
}

// Loads all kernels that a frame may need: external disparities and grids of other sources may come later.
void CudaStages::load_kernels() {
  for (const bool is_external : {true, false}) {
    is_external_ = is_external;
    enqueue_match();
  }
  split_surfaces();
  enqueue_walk({{}, rings_of(config_), {}});
  find_low_obstacles();
  find_ground();
  count_nodes();
  begin_count();
  for (const bool is_usable : {false, true}) enqueue_observation(is_usable);
  project_to_vehicle();
  if (!options_.filters) return;
  stereogrid::fuse_cameras(cuda_, {}, device_.observed.view());
  reset(cuda_, device_.filter, &device_.set.data()->motion, device_.states[now_]);
  enqueue_filter(true);
  enqueue_finish({true, true, true});
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
  join();
  cuda_.synchronize();
  is_at_work_ = false;
  is_filtering_ = false;
}

// Inputs that change from frame to frame are written to where the graphs read them.
void CudaStages::put_frame(const LevelFrame& frame, const FrameGrids& grids) {
  is_external_ = frame.has_external_disparity();
  options_.copy(rig_.height_px, [&](int begin, int end) {
    if (is_external_) return put(frame.disparity, begin, end, host_.given());
    put(frame.left, begin, end, host_.left());
    put(frame.right, begin, end, host_.right());
  });
  host_.frame().seen_vehicle = grids.seen_vehicle;
  host_.frame().seen_window = grids.seen_window;
}

void CudaStages::put_set(const FrameGrids& grids) {
  const FrameSet& set{grids.frame};
  const std::span views{set.views};
  const CameraView view{views.empty() ? CameraView{} : views.front()};
  *host_.set.data() = {grids.vehicle, grids.window_cells, grid_in_vehicle(sizes_.vehicle, set.world_from_vehicle),
                       grids.window,
                       filter_motion({config_.filter, filter_tables_, grids.window, set.dt_s, view, nullptr,
                                      views.empty() ? views : views.subspan(1)},
                                     grids.is_first ? grids.window : window_before_)};
  upload(cuda_, host_.set.data(), 1, device_.set.data());
  if (!set.other_grids.empty()) device_.other_grids.take(cuda_, set.other_grids);
}

// Waits, also after an exception, until the device does not read the memory that is written now.
void CudaStages::match(const LevelFrame& frame, const FrameGrids& grids, const RowAlignment& rows,
                       const MatchGround& ground) {
  cuda_.use();
  if (is_at_work_) synchronize();
  if (ground.surface != nullptr) {
    put_ground(cuda_, ground.plane);
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
  perform(cuda_, match_graphs_[is_external_ ? 1 : 0], [this] { enqueue_match(); });
  times_.mark(cuda_, StreamTimes::answered);
  is_lattice_taken_ = false;
}

const Matches& CudaStages::read() {
  const std::scoped_lock lock{reading_};
  cuda_.use();
  times_.wait_for(StreamTimes::answered);
  if (!is_lattice_taken_) scatter_lattice();
  is_lattice_taken_ = true;
  return matches_;
}

// Waits for the noise only: the device continues with the walk.
const float* CudaStages::begin_walk(const WalkFrame& frame) {
  cuda_.use();
  is_at_work_ = true;
  enqueue_walk(frame);
  times_.wait_for(StreamTimes::measured);
  return device_.terrain.host_sigma_px.data();
}

void CudaStages::begin_low_obstacles(const LowModel& model, std::span<const float> noise_px) {
  cuda_.use();
  low_obstacles_.put(model, noise_px);
  perform(beside_, low_obstacles_graph_, [this] { find_low_obstacles(); });
  join();
}

void CudaStages::find_ground(FrameTerrain& terrain, FrameResult&) {
  cuda_.use();
  ground_.put(terrain.ground_frame(), device_.terrain.frame.rings, device_.terrain.walked);
  perform(cuda_, ground_graph_, [this] { find_ground(); });
  times_.mark(cuda_, StreamTimes::grounded);
}

void CudaStages::finish_ground(FrameTerrain& terrain, FrameResult& result) {
  cuda_.use();
  times_.wait_for(StreamTimes::grounded);
  terrain.set_walked(device_.terrain.on_host());
  terrain.set_ground(ground_.found(), result);
  terrain.mark_low_obstacles(low_obstacles_.found(), result);
}

void CudaStages::put_ground(Cuda& cuda, const Ground& ground) {
  host_.frame().ground = ground;
  upload(cuda, &host_.frame().ground, 1, &device_.frame()->ground);
}

// The first time in a frame, nothing reads the memory that is written: the ground's kernels may still be at work.
void CudaStages::observe(const FrameGrids&, const Evidence& evidence, FrameResult&) {
  cuda_.use();
  if (has_observed_ || is_external_) synchronize();
  if (evidence.is_usable) {
    times_.let_wait(beside_, StreamTimes::answered);
    put_ground(beside_, evidence.ground);
    columns_.put(beside_, evidence.ground);
    begin_count();
    join();
    *host_.blur_px.data() = evidence.blur_px;
  }
  has_observed_ = true;
  times_.mark(cuda_, StreamTimes::resumed);
  if (evidence.is_usable) count_nodes();
  perform(cuda_, observe_graphs_[evidence.is_usable ? 1 : 0], [&] { enqueue_observation(evidence.is_usable); });
  if (!evidence.is_usable) return;
  times_.mark(cuda_, StreamTimes::seen);
  times_.let_wait(beside_, StreamTimes::seen);
  perform(beside_, vehicle_graph_, [this] { project_to_vehicle(); });
}

// The stream of the filter waits for those of the cameras, and a camera's next observation for the filter's.
void CudaStages::fuse_cameras(std::span<const CameraGrids> cameras, FrameResult&) {
  cuda_.use();
  is_at_work_ = true;
  std::array<View<const float, Device>, cameras_max> vehicle;
  std::array<View<const float, Device>, cameras_max> window;
  for (std::size_t i{0}; i < cameras.size(); ++i) {
    CudaStages& camera{static_cast<CudaStages&>(*cameras[i].stages)};
    camera.join();
    vehicle[i] = camera.device_.observed.view();
    window[i] = camera.device_.observed_window.view();
    download(camera.cuda_, camera.device_.observed.data(), camera.device_.observed.size(),
             camera.host_.observed.data());
    camera.is_one_of_several_ = true;
    camera.times_.mark(camera.cuda_, StreamTimes::observed);
    camera.times_.let_wait(cuda_, StreamTimes::observed);
  }
  stereogrid::fuse_cameras(cuda_, {vehicle.data(), cameras.size()}, device_.observed.view());
  stereogrid::fuse_cameras(cuda_, {window.data(), cameras.size()}, device_.observed_window.view());
  times_.mark(cuda_, StreamTimes::fused);
  for (const CameraGrids& camera : cameras)
    times_.let_wait(static_cast<CudaStages&>(*camera.stages).cuda_, StreamTimes::fused);
}

std::span<const ColumnNode> CudaStages::find_nodes(const Ground&, Relief<Host>& relief) {
  cuda_.use();
  times_.wait_for(StreamTimes::observed);
  const View<const std::int16_t, Device> rows{device_.rays.relief_view().rows};
  if (has_terrain()) relief = {{host_.relief.data(), rows.width, rows.height, rows.pitch}};
  return columns_.nodes();
}

// The filter of a frame without one of this camera, and once more after it: nothing else has waited.
void CudaStages::filter(const FrameGrids& grids, const FilterEvidence& evidence, FrameResult&) {
  cuda_.use();
  if (is_filtering_) synchronize();
  is_at_work_ = is_filtering_ = true;
  has_grids_ = false;
  put_set(grids);
  std::copy(evidence.held.begin(), evidence.held.end(), host_.held.data());
  *host_.held_count.data() = static_cast<int>(evidence.held.size());
  std::copy(evidence.velocities.begin(), evidence.velocities.end(), host_.evidence.data());
  *host_.evidence_count.data() = static_cast<int>(evidence.velocities.size());
  if (grids.is_first) reset(cuda_, device_.filter, &device_.set.data()->motion, device_.states[1 - now_]);
  const bool has_others{!grids.frame.other_grids.empty()};
  if (has_others) join();
  perform(cuda_, filter_graphs_[has_others ? 1 : 0][now_], [this, has_others] { enqueue_filter(has_others); });
  times_.mark(cuda_, StreamTimes::filtered);
  device_.fetch_window(cuda_, host_);
  times_.mark(cuda_, StreamTimes::fetched);
}

// The first time without a graph: what the driver prepares at a kernel's first launch does not belong into a recording.
template <class Work>
void CudaStages::perform(Cuda& cuda, Graph& graph, const Work& work) {
  is_at_work_ = true;
  if (has_graphs_ && !graph.empty()) return graph.launch(cuda);
  work();
  if (has_graphs_) graph.capture(cuda, work);
}

// Lets all further work wait for that beside it.
void CudaStages::join() {
  times_.mark(beside_, StreamTimes::beside);
  times_.let_wait(cuda_, StreamTimes::beside);
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
  if (has_terrain()) {
    stereogrid::find_medians(cuda_, std::as_const(device_.matches.obstacle).view(),
                             std::as_const(device_.matches.road).view(), device_.terrain);
  }
  device_.fetch_answer(cuda_, host_);
}

void CudaStages::enqueue_walk(const WalkFrame& frame) {
  times_.let_wait(beside_, StreamTimes::answered);  // waits for a second match of external disparities, too
  find_trenches(beside_, frame.ground, device_.terrain);
  stereogrid::begin_walk(cuda_, frame, device_.terrain);
  times_.mark(cuda_, StreamTimes::measured);
  join();
  find_walk(cuda_, device_.terrain);
}

void CudaStages::find_low_obstacles() {
  low_obstacles_.find(beside_, std::as_const(device_.matches.obstacle).view(),
                      std::as_const(device_.matches.road).view());
}

void CudaStages::find_ground() {
  DeviceBuffer<std::int16_t>& relief{device_.rays.relief};
  const View<const std::int16_t, Device> rows{device_.rays.relief_view().rows};
  ground_.find(cuda_, low_obstacles_.on_device(), {relief.data(), rows.width, rows.height, rows.pitch});
  download(cuda_, relief.data(), relief.size(), host_.relief.data());
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
  if (is_usable) {
    count();
    times_.mark(cuda_, StreamTimes::counted);
    if (!counts_rays())
      find_largest(cuda_, std::as_const(device_.u_disparity.occupancy_smooth).view(), device_.projection);
    project(cuda_, &device_.frame()->seen_window, ground_.window_rules(), device_.observed_window);
  } else {
    times_.mark(cuda_, StreamTimes::counted);
    device_.observe_nothing(cuda_);
  }
  times_.mark(cuda_, StreamTimes::projected);
}

// Without a graph, for the host waits for them alone.
void CudaStages::count_nodes() {
  columns_.count(cuda_, std::as_const(device_.matches.obstacle).view(), device_.rays.relief_view());
  times_.mark(cuda_, StreamTimes::observed);
}

// Needs the frame's plane alone.
void CudaStages::begin_count() {
  if (counts_rays()) begin_rays(beside_, rig_, &device_.frame()->ground, config_.u_disparity, device_.rays);
}

void CudaStages::count() {
  const MatchViews matches{std::as_const(device_.matches.obstacle).view(), std::as_const(device_.matches.road).view()};
  if (counts_rays()) count_rays(cuda_, matches, device_.rays);
  if (!counts_rays() || options_.stage_images)
    stereogrid::count(cuda_, matches, rig_, &device_.frame()->ground, device_.u_disparity);
}

void CudaStages::project(Cuda& cuda, const GridInVehicle* grid, const CellRule* rules, DeviceImage<float>& cells) {
  if (counts_rays())
    project_rays(cuda, device_.rays, BinGeometry{rig_}, grid, host_.blur_px.data(), cells.view());
  else
    stereogrid::project(cuda, std::as_const(device_.u_disparity.occupancy_smooth).view(), BinGeometry{rig_}, grid,
                        device_.projection, cells.view());
  if (has_terrain()) apply_rules(cuda, rules, cells.view());
}

// The filter does not wait for it.
void CudaStages::project_to_vehicle() {
  project(beside_, &device_.frame()->seen_vehicle, ground_.vehicle_rules(), device_.observed);
}

void CudaStages::enqueue_filter(bool has_others) {
  const FrameSetOnDevice* set{device_.set.data()};
  times_.mark(cuda_, StreamTimes::filtering);
  if (has_others) {
    fuse(cuda_, device_.other_grids, &set->vehicle_cells, config_.fusion, device_.observed.view());
    fuse(cuda_, device_.other_grids, &set->window_cells, config_.fusion, device_.observed_window.view());
  }
  stereogrid::hold(cuda_, host_.held.data(), host_.held_count.data(), device_.observed_window.view());
  stereogrid::filter(cuda_, device_.filter, &set->motion, std::as_const(device_.observed_window).view(),
                     device_.states[1 - now_], device_.states[now_], device_.world);
  if (config_.filter.model == FilterModel::joint) {
    stereogrid::weigh_velocities(cuda_, device_.filter, host_.evidence.data(), host_.evidence_count.data(),
                                 device_.states[now_], device_.world);
  }
  stereogrid::resample(cuda_, device_.world, &set->window, &set->vehicle_in_world, device_.vehicle);
  device_.fetch_occupancy(cuda_, host_);
}

void CudaStages::enqueue_finish(const FinalStep& step) {
  const FrameSetOnDevice* set{device_.set.data()};
  times_.mark(cuda_, StreamTimes::finishing);
  if (step.is_corrected) {
    correct_by_frame(cuda_, device_.world, &set->window, &set->vehicle_cells, &set->vehicle_in_world,
                     std::as_const(device_.observed).view(), step.is_widened, device_.vehicle);
  }
  if (has_terrain()) {
    const auto bounds_of = [](const DeviceImage<float>& cells, const std::uint8_t* bounds) {
      return View<const std::uint8_t, Device>{bounds, cells.width(), cells.height(), cells.width()};
    };
    bound_grids(cuda_,
                {bounds_of(device_.vehicle.occupancy, host_.vehicle_bounds.data()),
                 bounds_of(device_.world.occupancy, host_.window_bounds.data())},
                {device_.vehicle.age_s.data(), device_.observed.data(), device_.vehicle.occupancy.data(),
                 host_.witness.data(), device_.world.age_s.data(), device_.world.occupancy.data()});
  }
  if (step.is_completed)
    complete_unobserved(cuda_, device_.world, &set->window, &set->vehicle_in_world, device_.vehicle);
  device_.fetch_final(cuda_, host_);
  times_.mark(cuda_, StreamTimes::finished);
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

View<const float> CudaStages::filtered(const FrameResult&) {
  cuda_.use();
  times_.wait_for(StreamTimes::filtered);
  const int cells{sizes_.window};
  return {host_.grids.data() + PackedGrids{sizes_}.world, cells, cells, cells};
}

void CudaStages::finish(const FrameGrids&, const FinalStep& step, FrameResult& result) {
  cuda_.use();
  std::copy_n(step.bounds.vehicle.data, step.bounds.vehicle.width * step.bounds.vehicle.height,
              host_.vehicle_bounds.data());
  std::copy_n(step.bounds.window.data, step.bounds.window.width * step.bounds.window.height,
              host_.window_bounds.data());
  std::ranges::copy(result.witness, host_.witness.data());
  join();
  perform(cuda_, finish_graphs_[step.is_corrected ? 1 : 0][step.is_widened ? 1 : 0], [&] { enqueue_finish(step); });
}

// Layers that the filter has left are copied while the device works on the final grids.
void CudaStages::publish(const FrameGrids& grids, FrameResult& result) {
  cuda_.use();
  const auto copy = [&](int first, int last) {
    options_.copy(last - first, [&](int begin, int end) {
      PackedGrids::copy_to(host_.grids.data(), first + begin, first + end, result);
    });
  };
  if (options_.filters) {
    times_.wait_for(StreamTimes::fetched);
    copy(PackedGrids::window, PackedGrids::window_end);
  }
  synchronize();
  result.timing_ms = times_.stages(std::exchange(has_observed_, false), options_.filters);
  if (!options_.filters) return;
  Stopwatch watch;
  result.world.geometry = grids.window;
  copy(0, PackedGrids::window);
  copy(PackedGrids::window_end, PackedGrids::images);
  std::copy_n(host_.witness.data(), result.witness.size(), result.witness.data());
  result.timing_ms.filter += watch.lap();
  now_ = 1 - now_;
  window_before_ = grids.window;
  has_grids_ = true;
}

void CudaStages::fetch(const DeviceImages& images, StereoFrame& into) {
  cuda_.use();
  times_.mark(reinterpret_cast<cudaStream_t>(images.stream), StreamTimes::exchanged);
  times_.let_wait(cuda_, StreamTimes::exchanged);
  const auto copy = [this]<class T>(View<const T, Device> from, Image<T>& to) {
    if (to.width() != from.width || to.height() != from.height) to = Image<T>{from.width, from.height};
    if (from.empty()) return;
    const std::size_t row_bytes{static_cast<std::size_t>(from.width) * sizeof(T)};
    check_cuda(cudaMemcpy2DAsync(to.data(), row_bytes, from.data, static_cast<std::size_t>(from.pitch) * sizeof(T),
                                 row_bytes, static_cast<std::size_t>(from.height), cudaMemcpyDefault, cuda_.stream()),
               "copy images from the device");
  };
  copy(images.left, into.left);
  copy(images.right, into.right);
  copy(images.disparity, into.disparity);
  synchronize();
}

// The host has waited for them.
DeviceGrids CudaStages::device_grids() {
  if (!has_grids_) throw InputError{"device_grids()", "is called before a frame.", "Process one."};
  return {device_.observed.data(), device_.vehicle.occupancy.data(), device_.world.occupancy.data()};
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
  if (is_one_of_several_) std::copy_n(host_.observed.data(), host_.observed.size(), result.observed.data());
  if (!options_.stage_images) return;
  device_.fetch_stages(cuda_, result.stages);
  set_obstacles(std::as_const(result.stages.obstacle_disparity).view(), result.stages);
}

}  // namespace stereogrid
