// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda/frame.hpp"

#include <algorithm>

#include "backend/warp.cuh"

namespace stereogrid {
namespace {

constexpr int threads{256};
constexpr int count_blocks{FrameFromDevice::counting_warps * warp / threads};

std::size_t size_of(const GridGeometry& grid) {
  return static_cast<std::size_t>(grid.nx) * static_cast<std::size_t>(grid.ny);
}
std::size_t square(int side) {
  return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
}
std::size_t pixels_of(const Rig& rig) {
  return static_cast<std::size_t>(rig.width_px) * static_cast<std::size_t>(rig.height_px);
}
MatchLattice lattice_of(const Rig& rig) {
  return {rig.width_px, rig.height_px};
}
int lattice_size(const Rig& rig) {
  return lattice_of(rig).across * lattice_of(rig).down;
}

// Each warp leaves what it has counted.
__global__ void count_matched(const float* obstacle, const float* road, int pixels, MatchedPixels* matched) {
  int counts[2]{};
  const int step{static_cast<int>(gridDim.x) * threads};
  const int thread{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)};
  for (int i{thread}; i < pixels; i += step) {
    counts[0] += obstacle[i] > 0 ? 1 : 0;
    counts[1] += road[i] > 0 ? 1 : 0;
  }
  for (int& count : counts) count = sum_of_warp(count);
  if (threadIdx.x % warp == 0) matched[thread / warp] = {counts[0], counts[1]};
}

__global__ void fill(float* cells, int count, float value) {
  const int i{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)};
  if (i < count) cells[i] = value;
}

template <class T>
void fetch_image(Cuda& cuda, const DeviceImage<T>& device, Image<T>& image) {
  download(cuda, device.data(), image.size(), image.data());
}

// Behind `end`, where anything can begin.
std::size_t next_part(std::size_t end) {
  constexpr std::size_t alignment{256};
  return (end + alignment - 1) / alignment * alignment;
}

}  // namespace

FrameLayout::FrameLayout(const Rig& rig)
    : left{next_part(sizeof(FrameOnDevice))},
      right{next_part(left + pixels_of(rig))},
      images_end{right + pixels_of(rig)},
      given_end{left + pixels_of(rig) * sizeof(float)},
      lattice{next_part(sizeof(FrameFromDevice))},
      answer_end{lattice + static_cast<std::size_t>(lattice_size(rig)) * sizeof(float)} {}

GridSizes::GridSizes(const GridGeometry& vehicle_grid, bool filters)
    : vehicle{vehicle_grid},
      window{Window{vehicle_grid}.cells()},
      filtered_vehicle{filters ? vehicle_grid : GridGeometry{}},
      filtered_window{filters ? window : 0} {}

PackedGrids::PackedGrids(const GridSizes& sizes)
    : world{size_of(sizes.vehicle)},
      vehicle{world + LayersOnDevice::floats_of(sizes.filtered_window, sizes.filtered_window)},
      size{vehicle + LayersOnDevice::floats_of(sizes.filtered_vehicle.nx, sizes.filtered_vehicle.ny)} {}

void PackedGrids::copy_to(const float* packed, int begin, int end, FrameResult& result) {
  int i{0};
  const auto copy = [&](Image<float>& image) {
    if (begin <= i && i < end) std::copy_n(packed, image.size(), image.data());
    packed += image.size();
    ++i;
  };
  copy(result.observed);
  for (GridLayers* const grid : {&result.world, &result.vehicle}) {
    for (Image<float>* const image : {&grid->occupancy, &grid->velocity_x, &grid->velocity_y, &grid->age_s,
                                      &grid->velocity_xx, &grid->velocity_xy, &grid->velocity_yy, &grid->moving})
      copy(*image);
  }
}

HostMemory::HostMemory(const Rig& rig, const GridSizes& sizes, std::size_t relief_size)
    : layout{rig},
      input{std::max(layout.images_end, layout.given_end)},
      output{layout.answer_end},
      set{1},
      grids{PackedGrids{sizes}.size},
      vehicle_bounds{size_of(sizes.filtered_vehicle)},
      window_bounds{square(sizes.filtered_window)},
      witness{size_of(sizes.filtered_vehicle)},
      observed{size_of(sizes.vehicle)},
      evidence{square(sizes.filtered_window)},
      evidence_count{1},
      held{retained_cells_max},
      held_count{1},
      blur_px{1},
      relief{relief_size} {}

DeviceMemory::DeviceMemory(Cuda& cuda, const Config& config, const Rig& rig, const GridSizes& sizes,
                           const FilterTables& tables)
    : layout{rig},
      input{std::max(layout.images_end, layout.given_end)},
      output{layout.answer_end},
      set{1},
      grids{PackedGrids{sizes}.size},
      left{rig.width_px, rig.height_px, at<std::uint8_t>(input, layout.left)},
      right{rig.width_px, rig.height_px, at<std::uint8_t>(input, layout.right)},
      given{rig.width_px, rig.height_px, at<float>(input, layout.left)},
      lattice{lattice_of(rig).across, lattice_of(rig).down, at<float>(output, layout.lattice)},
      aligned{rig.width_px, rig.height_px},
      masked{rig.width_px, rig.height_px},
      matches{rig.width_px, rig.height_px},
      terrain{cuda, config.ground.model == GroundModel::terrain ? rig : Rig{}, config.matching.window_px,
              rings_of(config)},
      matching{rig.width_px, rig.height_px, config.matching},
      u_disparity{cuda, UDisparityTables{{config.u_disparity, config.paper}, rig.height_px, config.matching.window_px},
                  rig.width_px, rig.height_px, config.matching.disparities},
      projection{rig.width_px, config.matching.disparities},
      rays{rig.width_px, rig.height_px,
           config.projection.model == ProjectionModel::rays || config.ground.model == GroundModel::terrain
               ? config.matching.disparities
               : 0,
           config.ground.model == GroundModel::terrain},
      filter{cuda, config.filter, tables, sizes.filtered_window},
      states{{{cuda, config.filter, sizes.filtered_window}, {cuda, config.filter, sizes.filtered_window}}},
      observed{sizes.vehicle.nx, sizes.vehicle.ny, grids.data()},
      observed_window{sizes.window, sizes.window},
      world{sizes.filtered_window, sizes.filtered_window, grids.data() + PackedGrids{sizes}.world},
      vehicle{sizes.filtered_vehicle.nx, sizes.filtered_vehicle.ny, grids.data() + PackedGrids{sizes}.vehicle} {
  // external disparities have none
  clear(cuda, matches.confidence.data(), matches.confidence.size());
}

void DeviceMemory::upload_frame(Cuda& cuda, const HostMemory& host, bool is_external) {
  upload(cuda, host.input.data(), is_external ? layout.given_end : layout.images_end, input.data());
}

void DeviceMemory::fetch_answer(Cuda& cuda, HostMemory& host) {
  launch(cuda, count_matched, count_blocks, threads, 0, matches.obstacle.data(), matches.road.data(),
         static_cast<int>(matches.road.size()), answer()->matched);
  gather_lattice(cuda, matches.obstacle.view(), matches.road.view(), lattice.view());
  download(cuda, output.data(), layout.answer_end, host.output.data());
}

void DeviceMemory::observe_nothing(Cuda& cuda) {
  for (DeviceImage<float>* cells : {&observed, &observed_window}) {
    const int count{static_cast<int>(cells->size())};
    launch(cuda, fill, blocks_for(count, threads), threads, 0, cells->data(), count, 0.5f);
  }
}

void DeviceMemory::fetch_occupancy(Cuda& cuda, HostMemory& host) {
  const std::size_t offset{observed.size()};
  download(cuda, grids.data() + offset, world.occupancy.size(), host.grids.data() + offset);
}

void DeviceMemory::fetch_window(Cuda& cuda, HostMemory& host) {
  const std::size_t offset{observed.size() + world.occupancy.size()};
  download(cuda, grids.data() + offset, (LayersOnDevice::layers - 1) * world.occupancy.size(),
           host.grids.data() + offset);
}

void DeviceMemory::fetch_final(Cuda& cuda, HostMemory& host) {
  download(cuda, grids.data(), observed.size() + world.occupancy.size(), host.grids.data());
  const std::size_t offset{observed.size() + LayersOnDevice::layers * world.occupancy.size()};
  download(cuda, grids.data() + offset, grids.size() - offset, host.grids.data() + offset);
}

void DeviceMemory::fetch_stages(Cuda& cuda, StageImages& stages) const {
  fetch_image(cuda, matches.obstacle, stages.obstacle_disparity);
  fetch_image(cuda, matches.road, stages.road_disparity);
  fetch_image(cuda, matches.confidence, stages.match_confidence);
  download(cuda, u_disparity.possible.data(), stages.possible.size(), stages.possible.data());
  fetch_image(cuda, u_disparity.visible, stages.visible);
  fetch_image(cuda, u_disparity.observed, stages.observed);
  fetch_image(cuda, u_disparity.visibility, stages.visibility);
  fetch_image(cuda, u_disparity.obstacle_confidence, stages.obstacle_confidence);
  fetch_image(cuda, u_disparity.road_confidence, stages.road_confidence);
  fetch_image(cuda, u_disparity.occupancy, stages.occupancy);
  fetch_image(cuda, u_disparity.occupancy_smooth, stages.occupancy_smooth);
  cuda.synchronize();
}

StreamTimes::StreamTimes() {
  for (cudaEvent_t& event : events_) event = create_event();
}

StreamTimes::~StreamTimes() {
  for (const cudaEvent_t event : events_) {
    if (event != nullptr) cudaEventDestroy(event);
  }
}

void StreamTimes::mark(Cuda& cuda, Mark which) {
  if (cuda.is_loading()) return;
  cudaStreamCaptureStatus status{};
  check_cuda(cudaStreamIsCapturing(cuda.stream(), &status), "mark a time");
  const bool is_in_graph{status == cudaStreamCaptureStatusActive};
  check_cuda(is_in_graph ? cudaEventRecordWithFlags(events_[which], cuda.stream(), cudaEventRecordExternal)
                         : cudaEventRecord(events_[which], cuda.stream()),
             "mark a time");
}

void StreamTimes::mark(cudaStream_t stream, Mark which) {
  check_cuda(cudaEventRecord(events_[which], stream), "mark a stream");
}

void StreamTimes::wait_for(Mark which) {
  check_cuda(cudaEventSynchronize(events_[which]), "finish its work");
}

void StreamTimes::let_wait(Cuda& other, Mark which) const {
  check_cuda(cudaStreamWaitEvent(other.stream(), events_[which], 0), "wait for another stream");
}

double StreamTimes::between(Mark from, Mark to) const {
  float milliseconds{0};
  check_cuda(cudaEventElapsedTime(&milliseconds, events_[from], events_[to]), "measure time");
  return milliseconds;
}

StageTimes StreamTimes::stages(bool has_observed, bool has_filtered) const {
  StageTimes times;
  if (has_observed) {
    times.match = between(start, matched);
    times.count = between(resumed, counted);
    times.project = between(counted, projected);
  }
  if (has_filtered) times.filter = between(filtering, fetched) + between(finishing, finished);
  return times;
}

}  // namespace stereogrid
