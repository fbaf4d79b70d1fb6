// SPDX-License-Identifier: Apache-2.0
//
// Low obstacles on the device. Cells are those of a box of the window that has all samples, row by row.
#include <algorithm>
#include <cmath>

#include "backend/warp.cuh"
#include "terrain/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int threads{256};
constexpr int warps{threads / warp};
constexpr int blocks_per_processor{8};
constexpr int lowest{-32768};  ///< sample
constexpr int digits{16};      ///< bits of a sample

using Whole = long long;

__device__ int thread_of_grid() {
  return static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x);
}

// Calls work(cell, z) for the sample of a thread.
template <class Work>
__device__ void for_sample(const LowFrameOnDevice& frame, View<const float, Device> obstacle,
                           View<const float, Device> road, const Work& work) {
  const LowModel& model{frame.model};
  const int v{model.first_row + static_cast<int>(blockIdx.y)};
  if (v >= obstacle.height) return;
  const LowModel::Row row{model.row(v)};
  const int u{thread_of_grid() * row.step};
  if (u >= obstacle.width) return;
  const float disparity{Max(obstacle(u, v), road(u, v))};
  if (!model.is_in_range(disparity)) return;
  const LowModel::Place place{model.place(row, static_cast<float>(u), disparity)};
  const int ix{static_cast<int>(place.east)};
  const int iy{static_cast<int>(place.north)};
  if (model.is_sample(ix, iy, place.height) && frame.box.has(ix, iy))
    work(frame.box.index(ix, iy), static_cast<std::int16_t>(place.height));
}

__global__ void count_samples(const LowFrameOnDevice* frame, View<const float, Device> obstacle,
                              View<const float, Device> road, int* counts) {
  for_sample(*frame, obstacle, road, [=](int cell, std::int16_t) { atomicAdd(&counts[cell], 1); });
}

// Each cell's samples lie side by side, the cells' in any order. `ends`: begins, which sort_samples() moves.
__global__ void place_cells(const LowFrameOnDevice* frame, const int* counts, int* ends, int* placed) {
  const int cell{thread_of_grid()};
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const int count{cell < frame->box.size() ? counts[cell] : 0};
  int end{count};  // within the warp
  for (int apart{1}; apart < warp; apart *= 2) {
    const int before{__shfl_up_sync(whole_warp, end, static_cast<unsigned>(apart))};
    if (lane >= apart) end += before;
  }
  int begin{lane == warp - 1 && end > 0 ? atomicAdd(placed, end) : 0};
  begin = __shfl_sync(whole_warp, begin, warp - 1);
  if (cell < frame->box.size()) ends[cell] = begin + end - count;
}

__global__ void sort_samples(const LowFrameOnDevice* frame, View<const float, Device> obstacle,
                             View<const float, Device> road, int* ends, std::int16_t* sorted) {
  for_sample(*frame, obstacle, road, [=](int cell, std::int16_t z) { sorted[atomicAdd(&ends[cell], 1)] = z; });
}

// Number of the samples for which `is_counted`, up to 32 in most cells; all lanes of the warp together.
template <class IsCounted>
__device__ int count_of(const std::int16_t* samples, int size, const IsCounted& is_counted) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  int count{0};
  STEREOGRID_ROLLED for (int first{0}; first < size; first += warp) {
    const int i{first + lane};
    count += __popc(__ballot_sync(whole_warp, i < size && is_counted(samples[i])));
  }
  return count;
}

// The sample that has `rank` smaller ones, digit by digit: the largest number of which no more samples are smaller.
__device__ std::int16_t of_rank(const std::int16_t* samples, int size, int rank) {
  int found{lowest};
  for (int digit{digits - 1}; digit >= 0; --digit) {
    const int next{found + (1 << digit)};
    if (count_of(samples, size, [next](std::int16_t z) { return z < next; }) <= rank) found = next;
  }
  return static_cast<std::int16_t>(found);
}

// Calls work(cell, ix, iy, lane) for the cells of the box, with all lanes of a warp.
template <class Work>
__device__ void for_cells_of_warps(const LowBox& box, const Work& work) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  for (int cell{thread_of_grid() / warp}; cell < box.size(); cell += static_cast<int>(gridDim.x) * warps)
    work(cell, box.ix(cell), box.iy(cell), lane);
}

// A warp per cell.
__global__ void set_levels(const LowFrameOnDevice* frame, const float* noise_px, LowCellsOnDevice cells) {
  for_cells_of_warps(frame->box, [&](int cell, int ix, int iy, int lane) {
    const int samples{cells.counts[cell]};
    LowLevel level{LowModel::none_m, 0, 0};
    LowWeight<int> weight{0, 0};
    if (samples > 0) {
      const std::int16_t* const of_cell{cells.sorted + cells.ends[cell] - samples};
      const std::int16_t middle{of_rank(of_cell, samples, samples / 2)};
      const std::int16_t top{of_rank(of_cell, samples, samples - LowModel::decile_of(samples))};
      const float x{frame->model.places.x_of(ix, iy)};
      level = {LowModel::height_m(middle), LowModel::height_m(top), frame->model.noise_m(x, noise_px)};
      weight = frame->model.weighted<int>(0, x, level.middle_m, {}, level.noise_m);
    }
    if (lane != 0) return;
    cells.levels[cell] = level;
    cells.weights[cell] = weight;
    cells.planes[cell] = {LowModel::none_m, 0, 0, LowModel::none_m};
  });
}

// Sums of the weights along the rows of the box.
__global__ void sum_along(const LowFrameOnDevice* frame, LowCellsOnDevice cells) {
  const LowBox& box{frame->box};
  const int cell{thread_of_grid()};
  if (cell >= box.size()) return;
  const int reach{frame->model.reach};
  const int ix{box.ix(cell)};
  LowRowMoments<Whole> sum{};
  for (int x{max(ix - reach, box.first_x)}; x <= min(ix + reach, box.end_x - 1); ++x) {
    const LowWeight<int> weight{cells.weights[cell + x - ix]};
    sum.add({weight.n, weight.z}, x, 1);
  }
  cells.moments[cell] = sum;
}

// Planes, and weights of the next pass.
__global__ void fit_planes(const LowFrameOnDevice* frame, int pass, LowCellsOnDevice cells) {
  const LowBox& box{frame->box};
  const int cell{thread_of_grid()};
  if (cell >= box.size()) return;
  const LowLevel level{cells.levels[cell]};
  if (std::isnan(level.middle_m)) return;
  const int ix{box.ix(cell)};
  const int iy{box.iy(cell)};
  const int reach{frame->model.reach};
  LowMoments<Whole> sum{};
  for (int y{max(iy - reach, box.first_y)}; y <= min(iy + reach, box.end_y - 1); ++y)
    sum.add(cells.moments[box.index(ix, y)], y, 1);
  const LowPlane plane{LowModel::plane_of(sum, ix, iy, cells.planes[cell].z)};
  cells.planes[cell] = plane;
  const float x{frame->model.places.x_of(ix, iy)};
  cells.weights[cell] = frame->model.weighted<int>(pass + 1, x, level.middle_m, plane, level.noise_m);
}

// Depth of the lowest level below its plane; all lanes of the warp together.
__device__ float depth_around(const LowBox& box, int reach, int ix, int iy, const LowCellsOnDevice& cells) {
  const int lane{static_cast<int>(threadIdx.x) % warp};
  const int side{2 * reach + 1};
  float depth_m{0};
  for (int i{lane}; i < side * side; i += warp) {
    const int x{ix - reach + i % side};
    const int y{iy - reach + i / side};
    if (!box.has(x, y)) continue;
    const int cell{box.index(x, y)};
    depth_m = Max(depth_m, cells.planes[cell].z - cells.levels[cell].middle_m);
  }
  for (int apart{warp / 2}; apart > 0; apart /= 2) depth_m = Max(depth_m, __shfl_xor_sync(whole_warp, depth_m, apart));
  return depth_m;
}

// A warp per cell. Below the limit only the upper decile is compared.
__global__ void compare(const LowFrameOnDevice* frame, LowCellsOnDevice cells) {
  const LowModel& model{frame->model};
  for_cells_of_warps(frame->box, [&](int cell, int ix, int iy, int lane) {
    const LowPlane plane{cells.planes[cell]};
    LowSeen seen{};
    if (!std::isnan(plane.z)) {
      const LowLevel level{cells.levels[cell]};
      const int samples{cells.counts[cell]};
      const std::int16_t* const of_cell{cells.sorted + cells.ends[cell] - samples};
      const LowModel::Limits limits{model.limits_of(plane, model.places.x_of(ix, iy), level.noise_m)};
      const auto is_over = [&](float height_m) { return LowModel::is_over(limits, level.top_m, height_m); };
      const int most{is_over(limits.least_m) ? samples : LowModel::decile_of(samples)};
      const auto higher = [&](float height_m) {
        const float limit{LowModel::over(limits, height_m)};
        return count_of(of_cell, samples, [=](std::int16_t z) { return static_cast<float>(z) > limit; });
      };
      const bool may_be_obstacle{is_over(limits.matched_m) &&
                                 is_over(LowModel::depths * depth_around(frame->box, model.reach, ix, iy, cells))};
      const int raised{may_be_obstacle ? higher(LowModel::raised_share * limits.matched_m) : 0};
      const int high{min(most, higher(limits.least_m))};
      const int tall{high > 1 ? min(most, higher(model.limits.rays_from_m)) : 0};
      seen = model.seen(limits, level.top_m, samples, raised, high, tall);
    }
    if (lane == 0) cells.seen[cell] = seen;
  });
}

// Calls work(seen) for the cells of the box up to `reach` cells away.
template <class Work>
__device__ void for_around(const LowBox& box, int reach, int ix, int iy, const LowSeen* seen, const Work& work) {
  for (int y{max(iy - reach, box.first_y)}; y <= min(iy + reach, box.end_y - 1); ++y) {
    for (int x{max(ix - reach, box.first_x)}; x <= min(ix + reach, box.end_x - 1); ++x) work(seen[box.index(x, y)]);
  }
}

__global__ void write_cells(const LowFrameOnDevice* frame, LowCellsOnDevice cells, int* found, LowCell* written) {
  const LowBox& box{frame->box};
  const LowModel& model{frame->model};
  const int cell{thread_of_grid()};
  if (cell >= box.size()) return;
  const LowSeen seen{cells.seen[cell]};
  if (seen.count == 0) return;
  const int ix{box.ix(cell)};
  const int iy{box.iy(cell)};
  bool is_beside_tall{false};
  for_around(box, model.tall_reach, ix, iy, cells.seen, [&](const LowSeen& one) { is_beside_tall |= one.is_tall; });
  int raised{0};
  for_around(box, 1, ix, iy, cells.seen, [&](const LowSeen& one) { raised += one.raised; });
  if (LowModel::is_obstacle(seen, is_beside_tall) && model.is_small(model.places.x_of(ix, iy), raised)) return;
  written[atomicAdd(found, 1)] = LowModel::cell(ix, iy, seen, is_beside_tall, cells.levels[cell].noise_m);
}

std::size_t square(int side) {
  return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
}

// Samples lie between the corners of the visible ground; and a cell more, for what rounding may shift.
LowBox box_of(const LowModel& model, int width_px) {
  LowBox box{model.cells, model.cells, 0, 0};
  const auto cell_of = [](float place) { return static_cast<int>(std::floor(std::clamp(place, -2.0f, 1e6f))); };
  for (const float u : {0.0f, static_cast<float>(width_px)}) {
    for (const float disparity : {model.least_px, model.most_px}) {
      const LowModel::Place corner{model.place({0, 1}, u, disparity)};
      box.first_x = std::min(box.first_x, cell_of(corner.east) - 1);
      box.end_x = std::max(box.end_x, cell_of(corner.east) + 2);
      box.first_y = std::min(box.first_y, cell_of(corner.north) - 1);
      box.end_y = std::max(box.end_y, cell_of(corner.north) + 2);
    }
  }
  box.first_x = std::max(box.first_x, 0);
  box.first_y = std::max(box.first_y, 0);
  box.end_x = std::max(std::min(box.end_x, model.cells), box.first_x);
  box.end_y = std::max(std::min(box.end_y, model.cells), box.first_y);
  return box;
}

}  // namespace

LowObstaclesOnDevice::LowObstaclesOnDevice(const Rig& level_rig, int window_cells, int disparities)
    : width_px_{level_rig.width_px},
      height_px_{level_rig.height_px},
      frame_{1},
      frame_on_device_{1},
      noise_px_{static_cast<std::size_t>(Rings::last_place(disparities)) + 1},
      noise_on_device_{noise_px_.size()},
      counts_{square(window_cells)},
      ends_{counts_.size()},
      sorted_{static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_)},
      levels_{counts_.size()},
      weights_{counts_.size()},
      moments_{counts_.size()},
      planes_{counts_.size()},
      seen_{counts_.size()},
      sums_{2},
      found_{1},
      cells_{std::min(counts_.size(), sorted_.size())} {}

void LowObstaclesOnDevice::put(const LowModel& model, std::span<const float> noise_px) {
  *frame_.data() = {model, box_of(model, width_px_)};
  std::copy(noise_px.begin(), noise_px.end(), noise_px_.data());
}

void LowObstaclesOnDevice::find(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road) {
  const LowFrameOnDevice* const frame{frame_on_device_.data()};
  const LowCellsOnDevice cells{counts_.data(),  ends_.data(),    sorted_.data(), levels_.data(),
                               weights_.data(), moments_.data(), planes_.data(), seen_.data()};
  int* const placed{sums_.data()};
  int* const found{sums_.data() + 1};
  const dim3 pixels{blocks_for(width_px_, threads), static_cast<unsigned>(height_px_)};
  const unsigned of_threads{blocks_for(static_cast<int>(counts_.size()), threads)};
  const unsigned of_warps{std::min(blocks_for(static_cast<int>(counts_.size()), warps),
                                   static_cast<unsigned>(blocks_per_processor * cuda.multiprocessors()))};
  upload(cuda, frame_.data(), 1, frame_on_device_.data());
  upload(cuda, noise_px_.data(), noise_px_.size(), noise_on_device_.data());
  clear(cuda, counts_.data(), counts_.size());
  clear(cuda, sums_.data(), sums_.size());
  launch(cuda, count_samples, pixels, threads, 0, frame, obstacle, road, counts_.data());
  launch(cuda, place_cells, of_threads, threads, 0, frame, counts_.data(), ends_.data(), placed);
  launch(cuda, sort_samples, pixels, threads, 0, frame, obstacle, road, ends_.data(), sorted_.data());
  launch(cuda, set_levels, of_warps, threads, 0, frame, noise_on_device_.data(), cells);
  for (int pass{0}; pass < LowModel::plane_passes; ++pass) {
    launch(cuda, sum_along, of_threads, threads, 0, frame, cells);
    launch(cuda, fit_planes, of_threads, threads, 0, frame, pass, cells);
  }
  launch(cuda, compare, of_warps, threads, 0, frame, cells);
  launch(cuda, write_cells, of_threads, threads, 0, frame, cells, found, cells_.data());
  download(cuda, found, 1, found_.data());
}

}  // namespace stereogrid
