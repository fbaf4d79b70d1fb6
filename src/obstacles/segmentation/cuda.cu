// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/cuda.hpp"

#include <algorithm>

#include "backend/warp.cuh"

namespace stereogrid {
namespace {

constexpr int columns{8};  // columns of a block: a sector of memory, and of the relief
constexpr int threads{columns * warp};
constexpr int no_pixel{-1};

struct FrameColumns {
  View<const float, Device> obstacle;
  const UprightRow* limits;
  Relief<Device> relief;
  const ColumnBin* bins;
  int size;  ///< number of bins
};

// Bin of an obstacle pixel · 2, and 1 more below the height of obstacles.
__device__ int code_of(const FrameColumns& frame, int u, int v) {
  if (u >= frame.obstacle.width || v >= frame.obstacle.height) return no_pixel;
  const float disparity{frame.obstacle(u, v)};
  const UprightRow& on_plane{frame.limits[v]};
  if (!on_plane.is_upright(u, disparity) || is_between_surfaces(frame.obstacle.row(v), frame.obstacle.width, u))
    return no_pixel;
  const UprightRow local{on_plane.raised(frame.relief.is_plane() ? 0 : frame.relief.rows_at(u, disparity))};
  if (!local.is_upright(u, disparity)) return no_pixel;
  return 2 * static_cast<int>(disparity * column_bins_per_px) + (local.is_below_highest(u, disparity) ? 1 : 0);
}

// Adds `rows` from `first` on, a bit each, run by run.
__device__ void add_rows(ColumnTally& tally, int first, unsigned rows, int between, const ColumnBin& bin) {
  while (rows != 0) {
    const unsigned lowest{rows & (0U - rows)};
    const unsigned beyond{(rows + lowest) & ~rows};  // the bit behind the run; 0: the run has the last bit
    const int last{beyond == 0 ? warp - 1 : __ffs(static_cast<int>(beyond)) - 2};
    tally.add(first + __ffs(static_cast<int>(lowest)) - 1, first + last, between, bin);
    between = 0;
    rows &= rows + lowest;
  }
}

// Adds the pixels of a warp, a row each. `rows`: a word per bin, 0 before and after.
__device__ void add_pixels(int code, int first, ColumnTally* tallies, unsigned* rows, const ColumnBin* bins) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const int bin{code / 2};
  const unsigned between{__ballot_sync(whole_warp, code != no_pixel && code % 2 == 1)};
  if (code != no_pixel) atomicOr(&rows[bin], 1U << lane);
  __syncwarp();
  const unsigned of_bin{code == no_pixel ? 0U : rows[bin]};
  __syncwarp();
  if (of_bin != 0 && (of_bin & ((1U << lane) - 1)) == 0) {  // the first of its bin
    add_rows(tallies[bin], first, of_bin, __popc(of_bin & between), bins[bin]);
    rows[bin] = 0;
  }
  __syncwarp();
}

// Nodes of a warp's column.
__device__ void write_nodes(const FrameColumns& frame, int u, const ColumnTally* tallies, int* found,
                            ColumnNode* nodes) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  for (int first{1}; first + 1 < frame.size; first += warp) {
    const int k{first + lane};
    const bool is_one{k + 1 < frame.size &&
                      is_node(tallies[k], tallies[k - 1].pixels, tallies[k + 1].pixels, frame.bins[k])};
    const unsigned are_nodes{__ballot_sync(whole_warp, is_one)};
    if (are_nodes == 0) continue;
    int place{lane == 0 ? atomicAdd(found, __popc(are_nodes)) : 0};
    place = __shfl_sync(whole_warp, place, 0) + __popc(are_nodes & ((1U << lane) - 1));
    if (is_one) {
      nodes[place] = {static_cast<std::uint16_t>(u), static_cast<std::uint16_t>(k), tallies[k].pixels,
                      static_cast<std::uint16_t>(tallies[k].top - 1)};
    }
  }
}

// A warp per column, a lane per row, a thread per pixel. Pixels are read along the rows and counted along the columns.
__global__ void count_columns(FrameColumns frame, int* found, ColumnNode* nodes) {
  __shared__ int codes[warp][columns + 1];
  unsigned* const all_rows{dynamic_shared<unsigned>()};
  auto* const all_tallies{reinterpret_cast<ColumnTally*>(all_rows + columns * frame.size)};
  const int t{static_cast<int>(threadIdx.x)};
  for (int i{t}; i < columns * frame.size; i += threads) {
    all_rows[i] = 0;
    all_tallies[i] = {};
  }
  const int begin{static_cast<int>(blockIdx.x) * columns};
  const int column{t / warp};
  ColumnTally* const tallies{all_tallies + column * frame.size};
  for (int first{0}; first < frame.obstacle.height; first += warp) {
    codes[t / columns][t % columns] = code_of(frame, begin + t % columns, first + t / columns);
    __syncthreads();
    add_pixels(codes[t % warp][column], first, tallies, all_rows + column * frame.size, frame.bins);
    __syncthreads();
  }
  if (begin + column < frame.obstacle.width) write_nodes(frame, begin + column, tallies, found, nodes);
}

std::size_t nodes_max(const Rig& rig, int bins) {
  return static_cast<std::size_t>(rig.width_px) * static_cast<std::size_t>(std::min(rig.height_px, bins));
}

}  // namespace

ColumnsOnDevice::ColumnsOnDevice(Cuda& cuda, const Rig& level_rig, const UDisparityConfig& heights, int disparities)
    : geometry_{level_rig, heights, disparities},
      bins_{geometry_.bins.size()},
      limits_{static_cast<std::size_t>(level_rig.height_px)},
      limits_on_device_{limits_.size()},
      found_on_device_{1},
      found_{1},
      nodes_{nodes_max(level_rig, geometry_.size())} {
  upload(cuda, geometry_.bins.data(), bins_.size(), bins_.data());
  cuda.synchronize();
}

void ColumnsOnDevice::put(Cuda& cuda, const Ground& ground) {
  const UprightLimits limits{geometry_.limits(ground)};
  for (int v{0}; v < geometry_.rig.height_px; ++v) limits_.data()[v] = limits.row(v);
  upload(cuda, limits_.data(), limits_.size(), limits_on_device_.data());
}

void ColumnsOnDevice::count(Cuda& cuda, View<const float, Device> obstacle, const Relief<Device>& relief) {
  const std::size_t shared_bytes{static_cast<std::size_t>(columns * geometry_.size()) *
                                 (sizeof(unsigned) + sizeof(ColumnTally))};
  clear(cuda, found_on_device_.data(), 1);
  launch(cuda, count_columns, blocks_for(obstacle.width, columns), threads, shared_bytes,
         FrameColumns{obstacle, limits_on_device_.data(), relief, bins_.data(), geometry_.size()},
         found_on_device_.data(), nodes_.data());
  download(cuda, found_on_device_.data(), 1, found_.data());
}

}  // namespace stereogrid
