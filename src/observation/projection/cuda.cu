// SPDX-License-Identifier: Apache-2.0
#include "observation/projection/cuda.hpp"
#include "observation/projection/spans.hpp"

namespace stereogrid {
namespace {

constexpr int block_width{32};
constexpr int block_height{4};

__device__ float larger(float a, float b) {
  return a > b ? a : b;
}

__global__ void take_largest(View<const float, Device> occupancy, float* of_2, float* of_4, float* of_8) {
  const int u{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int d{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (u >= occupancy.width || d >= occupancy.height) return;
  const float* row{occupancy.row(d)};
  // columns beyond the last one are not used
  const auto at = [&](int column) { return row[column < occupancy.width ? column : occupancy.width - 1]; };
  const float two{larger(at(u), at(u + 1))};
  const float four{larger(two, larger(at(u + 2), at(u + 3)))};
  const float eight{larger(four, larger(larger(at(u + 4), at(u + 5)), larger(at(u + 6), at(u + 7))))};
  const int i{d * occupancy.width + u};
  of_2[i] = two;
  of_4[i] = four;
  of_8[i] = eight;
}

// Largest occupancy of many columns from that of 1, 2, 4 or 8 at a time; the last ones overlap.
struct Largest {
  int width;
  const float* of_1;
  const float* of_2;
  const float* of_4;
  const float* of_8;

  [[nodiscard]] __device__ float of(const BinSpan& span) const {
    const int columns{span.end - span.begin + 1};
    const int step{columns >= 8 ? 8 : (columns >= 4 ? 4 : (columns >= 2 ? 2 : 1))};
    const float* level{columns >= 8 ? of_8 : (columns >= 4 ? of_4 : (columns >= 2 ? of_2 : of_1))};
    const float* row{level + static_cast<std::ptrdiff_t>(width) * span.d};
    const int last{span.end + 1 - step};
    float highest{row[last]};
    for (int u{span.begin}; u < last; u += step) highest = larger(row[u], highest);
    return highest;
  }
};

// A thread per cell.
__global__ void project_cells(Largest largest, int disparities, BinGeometry bins, const GridInVehicle* grid,
                              View<float, Device> cells) {
  const int ix{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (ix >= cells.width || iy >= cells.height) return;
  const GridInVehicle place{*grid};
  const Spans spans{largest.width, disparities, bins, place};
  float highest{-1};
  const auto take = [&](const BinSpan& span) { highest = larger(largest.of(span), highest); };
  spans.by_overlap(ix, iy, take);
  cells(ix, iy) = highest < 0 ? 0.5f : highest;
}

dim3 blocks_of(int width, int height) {
  return {blocks_for(width, block_width), blocks_for(height, block_height)};
}

}  // namespace

ProjectionOnDevice::ProjectionOnDevice(int width, int disparities)
    : of_2{width, disparities}, of_4{width, disparities}, of_8{width, disparities} {}

void find_largest(Cuda& cuda, View<const float, Device> occupancy, ProjectionOnDevice& space) {
  launch(cuda, take_largest, blocks_of(occupancy.width, occupancy.height), dim3{block_width, block_height}, 0,
         occupancy, space.of_2.data(), space.of_4.data(), space.of_8.data());
}

void project(Cuda& cuda, View<const float, Device> occupancy, const BinGeometry& bins, const GridInVehicle* grid,
             const ProjectionOnDevice& space, View<float, Device> cells) {
  launch(cuda, project_cells, blocks_of(cells.width, cells.height), dim3{block_width, block_height}, 0,
         Largest{occupancy.width, occupancy.data, space.of_2.data(), space.of_4.data(), space.of_8.data()},
         occupancy.height, bins, grid, cells);
}

}  // namespace stereogrid
