// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>

#include "fusion/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int block_width{32};
constexpr int block_height{4};

__global__ void fuse_cells(const OtherGridsOnDevice::List* others, const GridInVehicle* grid, FusionConfig config,
                           View<float, Device> cells) {
  const int ix{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  const int count{others->count};
  if (count == 0 || ix >= cells.width || iy >= cells.height) return;
  IndependentPool pool;
  pool.add(static_cast<double>(cells(ix, iy)), config.stereo_confidence);
  const Point2 centre{grid->centre(ix, iy)};
  for (int i{0}; i < count; ++i) add(others->grids[i], centre, pool);
  cells(ix, iy) = static_cast<float>(pool.probability());
}

struct Cameras {
  View<const float, Device> cells[cameras_max];
  int count;
};

__global__ void pool_cameras(Cameras cameras, View<float, Device> cells) {
  const int ix{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (ix >= cells.width || iy >= cells.height) return;
  CameraPool pool;
  for (int i{0}; i < cameras.count; ++i) pool.add(cameras.cells[i](ix, iy));
  cells(ix, iy) = pool.probability();
}

constexpr int hold_threads{256};

// A single block: cells are held in few frames. Several cameras may hold the same; bits of positive floats are ordered.
__global__ void hold_cells(const RetainedCell* held, const int* count, View<float, Device> cells) {
  for (int i{static_cast<int>(threadIdx.x)}; i < *count; i += hold_threads) {
    float& cell{cells(held[i].cell % cells.width, held[i].cell / cells.width)};
    atomicMax(reinterpret_cast<int*>(&cell), __float_as_int(held[i].occupancy));
  }
}

}  // namespace

OtherGridsOnDevice::OtherGridsOnDevice() : list_{1}, grids_{1}, cells_{1} {}

void OtherGridsOnDevice::take(Cuda& cuda, std::span<const ObservedGrid> others) {
  std::size_t needed{0};
  for (const ObservedGrid& other : others) needed += other.occupancy.size() + other.confidence.size();
  cuda.synchronize();  // the frame before may still read the replaced memory
  if (needed > cells_.size()) cells_ = DeviceBuffer<float>{needed};
  if (others.size() > grids_.size()) grids_ = DeviceBuffer<OtherCells>{others.size()};
  sent_.clear();
  float* next{cells_.data()};
  const auto keep = [&](const Image<float>& image) {
    float* const at{next};
    upload(cuda, image.data(), image.size(), at);
    next += image.size();
    return at;
  };
  for (const ObservedGrid& other : others) {
    const float* occupancy{keep(other.occupancy)};
    sent_.push_back({other.geometry, occupancy, other.confidence.empty() ? nullptr : keep(other.confidence)});
  }
  const List list{static_cast<int>(sent_.size()), grids_.data()};
  if (!sent_.empty()) upload(cuda, sent_.data(), sent_.size(), grids_.data());
  upload(cuda, &list, 1, list_.data());
  cuda.synchronize();  // the source of the copy may be released by the caller
}

void fuse(Cuda& cuda, const OtherGridsOnDevice& others, const GridInVehicle* grid, const FusionConfig& config,
          View<float, Device> cells) {
  launch(cuda, fuse_cells, dim3{blocks_for(cells.width, block_width), blocks_for(cells.height, block_height)},
         dim3{block_width, block_height}, 0, others.list(), grid, config, cells);
}

void fuse_cameras(Cuda& cuda, std::span<const View<const float, Device>> cameras, View<float, Device> cells) {
  Cameras list{};
  std::copy(cameras.begin(), cameras.end(), list.cells);
  list.count = static_cast<int>(cameras.size());
  launch(cuda, pool_cameras, dim3{blocks_for(cells.width, block_width), blocks_for(cells.height, block_height)},
         dim3{block_width, block_height}, 0, list, cells);
}

void hold(Cuda& cuda, const RetainedCell* held, const int* count, View<float, Device> cells) {
  launch(cuda, hold_cells, 1, hold_threads, 0, held, count, cells);
}

}  // namespace stereogrid
