// SPDX-License-Identifier: Apache-2.0
#include "terrain/cuda.hpp"

#include "numbers.hpp"

namespace stereogrid {
namespace {

constexpr int rule_threads{256};

constexpr int sectors_per_block{8};
constexpr int rows_per_block{32};

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

__global__ void rule_cells(const CellRule* rules, View<float, Device> cells) {
  const int i{static_cast<int>(blockIdx.x) * rule_threads + static_cast<int>(threadIdx.x)};
  if (i >= cells.width * cells.height) return;
  float& cell{cells(i % cells.width, i / cells.width)};
  cell = ruled(cell, rules[i]);
}

}  // namespace

void find_medians(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                  TerrainOnDevice& terrain) {
  launch(cuda, find_sector_medians,
         {blocks_for(terrain.medians.height(), sectors_per_block), blocks_for(terrain.medians.width(), rows_per_block)},
         {sectors_per_block, rows_per_block}, 0, obstacle, road, terrain.medians.view());
}

void apply_rules(Cuda& cuda, const CellRule* rules, View<float, Device> cells) {
  launch(cuda, rule_cells, blocks_for(cells.width * cells.height, rule_threads), rule_threads, 0, rules, cells);
}

}  // namespace stereogrid
