// SPDX-License-Identifier: Apache-2.0
#include "terrain/cuda.hpp"

#include <utility>

#include "numbers.hpp"

namespace stereogrid {
namespace {

constexpr int rule_threads{256};

constexpr int sectors_per_block{8};
constexpr int rows_per_block{32};
constexpr int search_threads{256};

// Zeros come first in the sorted numbers.
__device__ float median_of(const float (&sorted)[sector_px]) {
  const float of_three{sorted[5] > 0 ? sorted[6] : 0.0f};  // three or four disparities
  const float of_five{sorted[3] > 0 ? sorted[5] : of_three};
  return sorted[1] > 0 ? sorted[4] : of_five;
}

// A thread per sector and row; a warp reads 64 pixels along four rows. Odd-even sort: all indices are constants.
__global__ void find_sector_medians(View<const float, Device> obstacle, View<const float, Device> road,
                                    View<float, Device> medians) {
  const int sector{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  const int v{static_cast<int>(blockIdx.y * blockDim.y + threadIdx.y)};
  if (sector >= medians.height || v >= medians.width) return;
  float column[sector_px];
  for (int k{0}; k < sector_px; ++k) {
    const int u{sector * sector_px + k};
    column[k] = u < obstacle.width ? Max(obstacle(u, v), road(u, v)) : 0;
  }
  for (int round{0}; round < sector_px; ++round) {
    for (int k{round % 2}; k + 1 < sector_px; k += 2) {
      const float least{Min(column[k], column[k + 1])};
      column[k + 1] = Max(column[k], column[k + 1]);
      column[k] = least;
    }
  }
  medians(v, sector) = median_of(column);
}

/// Input of the search for trenches.
struct TrenchFrame {
  SampledGround ground;
  View<const float, Device> medians;
  const TrenchShape* shapes;
  int margin;  ///< rows of ground around a trench
};

/// A block's shared memory; behind it the mean disparities of its sector by row.
struct SearchSpace {
  unsigned long long best;                     ///< key_of the best trench; 0: none yet
  int first;                                   ///< first row that is near enough
  int count;                                   ///< number of edges and shapes in `listed`
  int listed[search_threads * trench_shapes];  ///< edge · trench_shapes + shape

  [[nodiscard]] __device__ float* means() { return reinterpret_cast<float*>(this + 1); }
};

// The larger one wins: of equal gains > 0, that of the first in the CPU's order.
__device__ unsigned long long key_of(float gain, int order) {
  return static_cast<unsigned long long>(static_cast<unsigned>(__float_as_int(gain))) << 32 |
         (~0U - static_cast<unsigned>(order));
}

__device__ TrenchSearch search_of(const TrenchFrame& frame, int sector, const TrenchBounds& bounds,
                                  SearchSpace& space) {
  const View<const float, Device>& medians{frame.medians};
  for (int v{frame.ground.first_row + static_cast<int>(threadIdx.x)}; v < medians.width; v += search_threads) {
    float sum{0};
    float count{0};
    for (int i{-sectors_beside}; i <= sectors_beside; ++i) {
      const float there{medians(v, Min(Max(sector + i, 0), medians.height - 1))};
      sum += there;
      count += there > 0 ? 1 : 0;
    }
    space.means()[v] = mean_of_sectors(sum, count);
  }
  if (threadIdx.x == 0) space.best = 0;
  return {frame.ground, sector, bounds, frame.margin, space.means()};
}

// Lists the shapes that an edge may have.
__device__ void list_likely(const TrenchFrame& frame, const TrenchSearch& search, int edge, SearchSpace& space) {
  if (!(search.disparity[edge] > 0)) return;
  if (search.is_lower(edge)) space.listed[atomicAdd(&space.count, 1)] = edge * trench_shapes;
  for (int k{1}; k < trench_shapes; ++k) {
    const TrenchShape& shape{frame.shapes[k]};
    if (edge >= search.first_edge(shape) &&
        search.check(shape).is_likely(search.disparity + edge - shape.edge_place) != 0)
      space.listed[atomicAdd(&space.count, 1)] = edge * trench_shapes + k;
  }
}

// TrenchFilter::best: a thread per edge, then a thread per fit. Replaces *found by a better one. `before`: number of
// edges that were searched before.
__device__ void search_edges(const TrenchFrame& frame, const TrenchSearch& search, int lowest, int highest, int before,
                             SearchSpace& space, std::optional<Trench>* found) {
  const int t{static_cast<int>(threadIdx.x)};
  const int end{Min(lowest + 1, frame.medians.width - frame.margin)};
  if (t == 0) space.first = end;
  __syncthreads();
  for (int v{Max(highest, frame.ground.first_row + 1) + t}; v < end; v += search_threads) {
    if (search.is_near(v)) atomicMin(&space.first, v);
  }
  __syncthreads();
  unsigned long long own_key{0};
  std::optional<Trench> own;
  for (int begin{space.first}; begin < end; begin += search_threads) {
    if (t == 0) space.count = 0;
    __syncthreads();
    if (begin + t < end) list_likely(frame, search, begin + t, space);
    __syncthreads();
    for (int i{t}; i < space.count; i += search_threads) {
      const int edge{space.listed[i] / trench_shapes};
      const int k{space.listed[i] % trench_shapes};
      const std::optional<Trench> trench{search.at(frame.shapes[k], edge)};
      if (!trench) continue;
      const unsigned long long key{key_of(trench->gain, (before + end - 1 - edge) * trench_shapes + k)};
      if (key <= own_key) continue;
      own_key = key;
      own = trench;
    }
    __syncthreads();
  }
  if (own_key != 0) atomicMax(&space.best, own_key);
  __syncthreads();
  if (own_key != 0 && own_key == space.best) *found = own;
  __syncthreads();
}

// A block per sector that is searched.
__global__ void search_sectors(TrenchFrame frame, std::optional<Trench>* trenches) {
  const int sector{static_cast<int>(blockIdx.x) * TrenchFilter::step};
  SearchSpace& space{*dynamic_shared<SearchSpace>()};
  const TrenchSearch search{search_of(frame, sector, alone_bounds(), space)};
  if (threadIdx.x == 0) trenches[sector] = std::nullopt;
  search_edges(frame, search, frame.medians.width, frame.ground.first_row, 0, space, trenches + sector);
}

// A block per sector between two of them.
__global__ void search_between(TrenchFrame frame, std::optional<Trench>* trenches) {
  constexpr int between{TrenchFilter::step - 1};
  const int before{static_cast<int>(blockIdx.x) / between * TrenchFilter::step};
  const int sector{before + 1 + static_cast<int>(blockIdx.x) % between};
  SearchSpace& space{*dynamic_shared<SearchSpace>()};
  if (threadIdx.x == 0) trenches[sector] = std::nullopt;
  const TrenchSearch search{search_of(frame, sector, alone_bounds(), space)};
  for (const int there : {before, before + TrenchFilter::step}) {
    if (there >= frame.medians.height || !trenches[there]) continue;
    const int row{trenches[there]->row};
    search_edges(frame, search, row + chain_rows, row - chain_rows, there == before ? 0 : frame.medians.width, space,
                 trenches + sector);
  }
}

// TrenchFilter::connect, by one block. Few frames have a long chain.
__global__ void connect_trenches(TrenchFrame frame, std::optional<Trench>* trenches) {
  SearchSpace& space{*dynamic_shared<SearchSpace>()};
  const int t{static_cast<int>(threadIdx.x)};
  const TrenchChains chains{trenches, frame.medians.height};
  const auto has_any = [&](const auto& is_one) {
    int found{0};
    for (int sector{t}; sector < chains.sectors; sector += search_threads)
      found |= trenches[sector] && is_one(*trenches[sector]) ? 1 : 0;
    return __syncthreads_or(found) != 0;
  };
  if (!has_any([](const Trench&) { return true; })) return;
  if (t == 0) chains.connect(frame.ground);
  __syncthreads();
  if (!has_any([](const Trench& one) { return one.is_sure; })) return;
  for (const int side : {1, -1}) {
    for (int i{0}; i < chains.sectors; ++i) {
      const int sector{side > 0 ? i : chains.sectors - 1 - i};
      const Trench* const other{chains.extending(sector, side)};
      if (other == nullptr) continue;
      const TrenchSearch search{search_of(frame, sector, extension_bounds(), space)};
      search_edges(frame, search, other->row + chain_rows, other->row - chain_rows, 0, space, trenches + sector);
      if (t == 0 && trenches[sector]) trenches[sector]->is_sure = true;
      __syncthreads();
    }
  }
}

__global__ void rule_cells(const CellRule* rules, View<float, Device> cells) {
  const int i{static_cast<int>(blockIdx.x) * rule_threads + static_cast<int>(threadIdx.x)};
  if (i >= cells.width * cells.height) return;
  float& cell{cells(i % cells.width, i / cells.width)};
  cell = ruled(cell, rules[i]);
}

// A thread per cell of the vehicle's grid, and one per cell of the window.
__global__ void bound_cells(GridBounds<Device> bounds, BoundedGrids grids) {
  const int i{static_cast<int>(blockIdx.x) * rule_threads + static_cast<int>(threadIdx.x)};
  const int of_vehicle{bounds.vehicle.width * bounds.vehicle.height};
  const int of_window{i - of_vehicle};
  if (i < of_vehicle) {
    bound_cell(bounds.vehicle.data[i], grids.age_s[i], grids.observed[i], grids.occupancy[i], grids.witness[i]);
  } else if (of_window < bounds.window.width * bounds.window.height) {
    float& occupancy{grids.window_occupancy[of_window]};
    occupancy = bounded(occupancy, bounds.window.data[of_window], grids.window_age_s[of_window]);
  }
}

}  // namespace

void find_medians(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                  TerrainOnDevice& terrain) {
  launch(cuda, find_sector_medians,
         {blocks_for(terrain.medians.height(), sectors_per_block), blocks_for(terrain.medians.width(), rows_per_block)},
         {sectors_per_block, rows_per_block}, 0, obstacle, road, terrain.medians.view());
}

void find_trenches(Cuda& cuda, const SampledGround& ground, TerrainOnDevice& terrain) {
  const View<const float, Device> medians{std::as_const(terrain.medians).view()};
  const TrenchFrame frame{ground, medians, terrain.shapes.data(), trench_margin_of(terrain.window_px)};
  const std::size_t shared_bytes{sizeof(SearchSpace) + static_cast<std::size_t>(medians.width) * sizeof(float)};
  const int searched{(medians.height + TrenchFilter::step - 1) / TrenchFilter::step};
  std::optional<Trench>* const trenches{terrain.trenches.data()};
  launch(cuda, search_sectors, searched, search_threads, shared_bytes, frame, trenches);
  launch(cuda, search_between, medians.height - searched, search_threads, shared_bytes, frame, trenches);
  launch(cuda, connect_trenches, 1, search_threads, shared_bytes, frame, trenches);
}

void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells) {
  launch(cuda, rule_cells, blocks_for(cells.width * cells.height, rule_threads), rule_threads, 0, rules, cells);
}

void bound_grids(Cuda& cuda, const GridBounds<Device>& bounds, const BoundedGrids& grids) {
  const int cells{bounds.vehicle.width * bounds.vehicle.height + bounds.window.width * bounds.window.height};
  launch(cuda, bound_cells, blocks_for(cells, rule_threads), rule_threads, 0, bounds, grids);
}

}  // namespace stereogrid
