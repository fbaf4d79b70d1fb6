// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "pipeline/cuda/frame.hpp"

#include <algorithm>

namespace stereogrid {
namespace {

constexpr int threads{256};
constexpr int count_blocks{128};
constexpr unsigned whole_warp{0xffffffffU};

std::size_t size_of(const GridGeometry& grid) {
  return static_cast<std::size_t>(grid.nx) * static_cast<std::size_t>(grid.ny);
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

__global__ void count_matched(const float* obstacle, const float* road, int pixels, int* matched) {
  int counts[2]{};
  const int step{static_cast<int>(gridDim.x) * threads};
  for (int i{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)}; i < pixels; i += step) {
    counts[0] += obstacle[i] > 0 ? 1 : 0;
    counts[1] += road[i] > 0 ? 1 : 0;
  }
  for (int k{0}; k < 2; ++k) {
    for (int apart{16}; apart > 0; apart /= 2) counts[k] += __shfl_xor_sync(whole_warp, counts[k], apart);
    if (threadIdx.x % 32 == 0) atomicAdd(&matched[k], counts[k]);
  }
}

__global__ void fill(float* cells, int count, float value) {
  const int i{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)};
  if (i < count) cells[i] = value;
}

constexpr int packed_layers{1 + 2 * PackedGrids::layers};
constexpr int pack_blocks{32};

/// Where the layers lie, and where each begins in PackedGrids.
struct PackedLayers {
  const float* layer[packed_layers];
  int size[packed_layers];
  int begin[packed_layers];
};

// A row of blocks per layer.
__global__ void pack(PackedLayers from, float* packed) {
  const int k{static_cast<int>(blockIdx.y)};
  const int step{static_cast<int>(gridDim.x) * threads};
  for (int i{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)}; i < from.size[k]; i += step) {
    packed[from.begin[k] + i] = from.layer[k][i];
  }
}

template <class T>
void fetch_image(Cuda& cuda, const DeviceImage<T>& device, Image<T>& image) {
  download(cuda, device.data(), image.size(), image.data());
}

}  // namespace

PackedGrids::PackedGrids(const GridGeometry& vehicle_grid, int window_cells)
    : vehicle_cells{size_of(vehicle_grid)},
      world_cells{static_cast<std::size_t>(window_cells) * static_cast<std::size_t>(window_cells)} {}

void PackedGrids::copy_to(const float* packed, FrameResult& result) const {
  const auto take = [&](Image<float>& image) {
    std::copy_n(packed, image.size(), image.data());
    packed += image.size();
  };
  take(result.observed);
  for (GridLayers* grid : {&result.world, &result.vehicle}) {
    for (Image<float>* image : {&grid->occupancy, &grid->velocity_x, &grid->velocity_y, &grid->age_s,
                                &grid->velocity_xx, &grid->velocity_xy, &grid->velocity_yy, &grid->moving}) {
      take(*image);
    }
  }
}

HostMemory::HostMemory(const Rig& rig, const GridGeometry& vehicle_grid, int window_cells)
    : frame{1},
      answer{1},
      left{pixels_of(rig)},
      right{pixels_of(rig)},
      given{pixels_of(rig)},
      lattice{static_cast<std::size_t>(lattice_size(rig))},
      obstacle{pixels_of(rig)},
      grids{PackedGrids{vehicle_grid, window_cells}.size()},
      evidence{static_cast<std::size_t>(window_cells) * static_cast<std::size_t>(window_cells)},
      evidence_count{1} {}

DeviceMemory::DeviceMemory(Cuda& cuda, const Config& config, const Rig& rig, const GridGeometry& vehicle_grid,
                           int window_cells, const FilterTables& tables)
    : frame{1},
      answer{1},
      left{rig.width_px, rig.height_px},
      right{rig.width_px, rig.height_px},
      aligned{rig.width_px, rig.height_px},
      given{rig.width_px, rig.height_px},
      lattice{lattice_of(rig).across, lattice_of(rig).down},
      masked{rig.width_px, rig.height_px},
      matches{rig.width_px, rig.height_px},
      matching{rig.width_px, rig.height_px, config.matching},
      ground{rig.width_px, rig.height_px},
      u_disparity{cuda, UDisparityTables{config.u_disparity, rig.height_px, config.matching.window_px}, rig.width_px,
                  rig.height_px, config.matching.disparities},
      projection{rig.width_px, config.matching.disparities},
      rays{rig.width_px, rig.height_px,
           config.projection.model == ProjectionModel::rays ? config.matching.disparities : 0},
      filter{cuda, config.filter, tables, window_cells},
      states{{{config.filter, window_cells}, {config.filter, window_cells}}},
      observed{vehicle_grid.nx, vehicle_grid.ny},
      observed_window{window_cells, window_cells},
      world{window_cells, window_cells},
      vehicle{vehicle_grid.nx, vehicle_grid.ny},
      grids{PackedGrids{vehicle_grid, window_cells}.size()} {
  // given disparities come without
  clear(cuda, matches.confidence.data(), matches.confidence.size());
}

void DeviceMemory::upload_frame(Cuda& cuda, const HostMemory& host, bool is_given) {
  upload(cuda, host.frame.data(), 1, frame.data());
  if (is_given) return upload(cuda, host.given.data(), given.size(), given.data());
  upload(cuda, host.left.data(), left.size(), left.data());
  upload(cuda, host.right.data(), right.size(), right.data());
}

void DeviceMemory::fetch_answer(Cuda& cuda, HostMemory& host) {
  int* const matched{answer.data()->matched};
  clear(cuda, matched, 2);
  launch(cuda, count_matched, count_blocks, threads, 0, matches.obstacle.data(), matches.road.data(),
         static_cast<int>(matches.road.size()), matched);
  gather_lattice(cuda, matches.obstacle.view(), matches.road.view(), lattice.view());
  download(cuda, lattice.data(), lattice.size(), host.lattice.data());
  download(cuda, answer.data(), 1, host.answer.data());
  download(cuda, matches.obstacle.data(), matches.obstacle.size(), host.obstacle.data());
}

void DeviceMemory::observe_nothing(Cuda& cuda) {
  for (DeviceImage<float>* cells : {&observed, &observed_window}) {
    const int count{static_cast<int>(cells->size())};
    launch(cuda, fill, blocks_for(count, threads), threads, 0, cells->data(), count, 0.5f);
  }
}

void DeviceMemory::fetch_grids(Cuda& cuda, HostMemory& host) {
  PackedLayers from{};
  int count{0};
  std::size_t end{0};
  const auto add = [&](const DeviceImage<float>& image) {
    from.layer[count] = image.data();
    from.size[count] = static_cast<int>(image.size());
    from.begin[count] = static_cast<int>(end);
    end += image.size();
    ++count;
  };
  add(observed);
  for (const LayersOnDevice* layers : {&world, &vehicle}) {
    for (const DeviceImage<float>* image :
         {&layers->occupancy, &layers->velocity_x, &layers->velocity_y, &layers->age_s, &layers->velocity_xx,
          &layers->velocity_xy, &layers->velocity_yy, &layers->moving}) {
      add(*image);
    }
  }
  launch(cuda, pack, dim3{pack_blocks, packed_layers}, threads, 0, from, grids.data());
  download(cuda, grids.data(), grids.size(), host.grids.data());
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
  for (cudaEvent_t& event : events_) check_cuda(cudaEventCreate(&event), "create an event");
}

StreamTimes::~StreamTimes() {
  for (const cudaEvent_t event : events_) {
    if (event != nullptr) cudaEventDestroy(event);
  }
}

void StreamTimes::mark(Cuda& cuda, Mark which) {
  cudaStreamCaptureStatus status{};
  check_cuda(cudaStreamIsCapturing(cuda.stream(), &status), "mark a time");
  const bool is_in_graph{status == cudaStreamCaptureStatusActive};
  check_cuda(is_in_graph ? cudaEventRecordWithFlags(events_[which], cuda.stream(), cudaEventRecordExternal)
                         : cudaEventRecord(events_[which], cuda.stream()),
             "mark a time");
}

void StreamTimes::wait_for(Mark which) {
  check_cuda(cudaEventSynchronize(events_[which]), "finish its work");
}

double StreamTimes::between(Mark from, Mark to) const {
  float milliseconds{0};
  check_cuda(cudaEventElapsedTime(&milliseconds, events_[from], events_[to]), "measure time");
  return milliseconds;
}

StageTimes StreamTimes::stages() const {
  StageTimes times;
  times.match = between(start, matched);
  times.ground = between(matched, ground_known);
  times.count = between(ground_known, counted);
  times.project = between(counted, projected);
  times.filter = between(projected, fetched);
  return times;
}

}  // namespace stereogrid
