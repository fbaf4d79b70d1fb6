// SPDX-License-Identifier: Apache-2.0
//
// Relief of the ground and ground of the cells of both grids, on the device.
#include <algorithm>
#include <cmath>

#include "backend/warp.cuh"
#include "terrain/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int threads{256};
constexpr int warps{threads / warp};
constexpr int bits{32};  ///< digits of a number
constexpr unsigned sign{1U << (bits - 1)};
constexpr int marking_blocks{8};
constexpr int shares{2};  ///< sectors of a lane around a cell
static_assert(2 * ReliefModel::reach_max + 1 <= shares * warp);

using Frame = GroundFrame<Device>;

__device__ int lane_of_thread() {
  return static_cast<int>(threadIdx.x) % warp;
}

// Whole numbers in the order of the numbers; NaN: behind all others.
__device__ unsigned key_of(float number) {
  const auto same = static_cast<unsigned>(__float_as_int(number));
  if (std::isnan(number)) return ~0U;
  return (same & sign) != 0 ? ~same : same | sign;
}

__device__ float number_of(unsigned key) {
  return __int_as_float(static_cast<int>((key & sign) != 0 ? key ^ sign : ~key));
}

/// Elevations of a ring around a sector, some in each lane; NaN: none. All lanes of the warp together.
struct Around {
  float z[shares];
  int apart[shares];  ///< sectors

  template <class IsCounted>
  [[nodiscard]] __device__ int count(const IsCounted& is_counted) const {
    int sum{0};
    for (int k{0}; k < shares; ++k) sum += __popc(__ballot_sync(whole_warp, is_counted(z[k], apart[k])));
    return sum;
  }
  // Digit by digit: the largest number of which no more elevations are smaller.
  [[nodiscard]] __device__ float of_rank(int rank) const {
    unsigned found{0};
    STEREOGRID_ROLLED for (int digit{bits - 1}; digit >= 0; --digit) {
      const unsigned next{found | 1U << digit};
      if (count([next](float one, int) { return key_of(one) < next; }) <= rank) found = next;
    }
    return number_of(found);
  }
};

// TerrainRelief::wide_ground() by a warp.
__device__ float wide_ground(const ReliefModel& model, View<const float, Device> elevations, int sector, int ring) {
  const int reach{model.reach(ring)};
  const int first{Max(sector - reach, 0)};
  const int last{Min(sector + reach, elevations.height - 1)};
  Around around{};
  for (int k{0}; k < shares; ++k) {
    const int i{first + lane_of_thread() + k * warp};
    around.z[k] = i <= last ? elevations(ring, i) : ReliefModel::none_m;
    around.apart[k] = Abs(i - sector);
  }
  const int sectors{last + 1 - first};
  const int grounds{around.count([](float z, int) { return !std::isnan(z); })};
  if (!ReliefModel::is_most(grounds, sectors)) return ReliefModel::none_m;
  const float noise_m{model.noise_m[ring]};
  if (ReliefModel::is_most(around.count([=](float z, int) { return std::abs(z) < noise_m; }), sectors)) return 0;
  const float median{around.of_rank(grounds / 2)};
  const int reached{around.count([&](float z, int apart) { return model.is_reached(z, median, ring, apart); })};
  return ReliefModel::is_most(reached, sectors) ? median : ReliefModel::none_m;
}

// A thread per ring and sector.
__global__ void set_elevations(const Frame* frame, View<float, Device> elevations) {
  const View<const PolarCell, Device>& cells{frame->ground.cells};
  const int ring{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  const int sector{static_cast<int>(blockIdx.y)};
  if (ring < cells.width) elevations(ring, sector) = frame->relief.elevation(cells(ring, sector), ring);
}

// A block per sector: a warp per ring finds wide ground, one thread connects it, then a thread has a bin.
__global__ void find_relief(const Frame* frame, View<const float, Device> elevations, View<std::int16_t, Device> rows) {
  const ReliefModel& model{frame->relief};
  const View<const PolarCell, Device>& cells{frame->ground.cells};
  const int sector{static_cast<int>(blockIdx.x)};
  float* const ground{dynamic_shared<float>()};
  float* const border{ground + elevations.width};
  for (int ring{static_cast<int>(threadIdx.x) / warp}; ring < cells.width; ring += warps) {
    const bool is_excluded{model.is_before_obstacle(ring, cells.row(sector))};
    const float z{is_excluded ? ReliefModel::none_m : wide_ground(model, elevations, sector, ring)};
    if (lane_of_thread() == 0) ground[ring] = z;
  }
  __syncthreads();
  if (threadIdx.x == 0) {
    model.connect(ground);
    model.set_borders(ground, border);
  }
  __syncthreads();
  for (int bin{static_cast<int>(threadIdx.x)}; bin < rows.width; bin += threads)
    rows(bin, sector) = model.rows(model.bin_at(bin, 0), border);
}

__device__ CellGround ground_of(const Frame& frame, const GroundGrid& grid, int ix, int iy) {
  const float x{grid.places.x_of(ix, iy)};
  const PolarPlace at{polar_place(frame.geometry, x, grid.places.y_of(ix, iy))};
  const int ring{frame.ground.ring_of(at)};
  if (ring == no_ring) return {};
  const RingPart part{frame.ground.part_of(ring, at.first, at.last)};
  return part.has_ground() ? frame.ground.ground_at(x, part) : CellGround{};
}

/// Rules of both grids, row by row.
struct Rules {
  CellRule* of[2];
};

// A thread per cell of a grid. Those with ground are written side by side, a warp's at once.
__global__ void find_cells(const Frame* frame, Rules rules, int* found, GroundCell* written) {
  const GroundGrid& grid{frame->grids[blockIdx.y]};
  const int cell{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)};
  if (cell - lane_of_thread() >= grid.width * grid.height) return;
  const bool is_in{cell < grid.width * grid.height};
  const CellGround ground{is_in ? ground_of(*frame, grid, cell % grid.width, cell / grid.width) : CellGround{}};
  if (is_in) rules.of[blockIdx.y][cell] = rule_of(ground.kind);
  const bool has_ground{ground.kind != TerrainClass::unknown || !std::isnan(ground.elevation_m)};
  const unsigned with_ground{__ballot_sync(whole_warp, has_ground)};
  int begin{lane_of_thread() == 0 && with_ground != 0 ? atomicAdd(found, __popc(with_ground)) : 0};
  begin = __shfl_sync(whole_warp, begin, 0);
  const unsigned before{with_ground & ((1U << lane_of_thread()) - 1)};
  if (has_ground) written[begin + __popc(before)] = {static_cast<int>(blockIdx.y), cell, ground};
}

// A thread per low obstacle. Several may mark a cell.
__global__ void mark_low_obstacles(const Frame* frame, LowFound low, CellRule* rules) {
  const int width{frame->grids[0].width};
  const int first{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)};
  for (int i{first}; i < *low.count; i += static_cast<int>(gridDim.x) * threads) {
    const LowCell cell{low.cells[i]};
    if (cell.is_high)
      frame->within.for_cells(cell.ix, cell.iy, [=](int ix, int iy) { mark_obstacle(rules[iy * width + ix]); });
  }
}

}  // namespace

GroundOnDevice::GroundOnDevice(const Rig& level_rig, int rings, const GridGeometry& vehicle_grid, int window_cells)
    : sectors_{rings > 0 ? terrain_sectors(level_rig.width_px) : 0},
      frame_{1},
      frame_on_device_{1},
      by_ring_{static_cast<std::size_t>(2 * rings)},
      by_ring_on_device_{by_ring_.size()},
      elevations_{rings, sectors_},
      rules_{{{vehicle_grid.nx, vehicle_grid.ny}, {window_cells, window_cells}}},
      found_on_device_{1},
      found_{1},
      cells_{rules_[0].size() + rules_[1].size()} {}

void GroundOnDevice::put(const GroundFrame<Host>& frame, const RingTable& rings, const WalkedGround<Device>& walked) {
  const int count{rings.count()};
  std::copy_n(frame.relief.noise_m, count, by_ring_.data());
  std::copy_n(frame.ground.plane_sigma_m, count, by_ring_.data() + count);
  ReliefModel relief{frame.relief};
  relief.rings = rings;
  relief.sigma_px = walked.sigma_px;
  relief.noise_m = by_ring_on_device_.data();
  *frame_.data() = {relief,
                    {frame.ground.camera, rings, walked.sigma_px, by_ring_on_device_.data() + count, walked.cells},
                    frame.geometry,
                    frame.grids,
                    frame.within};
}

void GroundOnDevice::find(Cuda& cuda, LowFound low, View<std::int16_t, Device> relief) {
  const Frame* const frame{frame_on_device_.data()};
  const View<const float, Device> elevations{std::as_const(elevations_).view()};
  const Rules rules{{rules_[0].data(), rules_[1].data()}};
  const int most_cells{static_cast<int>(std::max(rules_[0].size(), rules_[1].size()))};
  const std::size_t shared_bytes{(2 * static_cast<std::size_t>(elevations.width) + 1) * sizeof(float)};
  upload(cuda, frame_.data(), 1, frame_on_device_.data());
  upload(cuda, by_ring_.data(), by_ring_.size(), by_ring_on_device_.data());
  clear(cuda, found_on_device_.data(), 1);
  launch(cuda, set_elevations, {blocks_for(elevations.width, threads), static_cast<unsigned>(sectors_)}, threads, 0,
         frame, elevations_.view());
  launch(cuda, find_relief, static_cast<unsigned>(sectors_), threads, shared_bytes, frame, elevations, relief);
  launch(cuda, find_cells, {blocks_for(most_cells, threads), 2}, threads, 0, frame, rules, found_on_device_.data(),
         cells_.data());
  launch(cuda, mark_low_obstacles, marking_blocks, threads, 0, frame, low, rules.of[0]);
  download(cuda, found_on_device_.data(), 1, found_.data());
}

}  // namespace stereogrid
