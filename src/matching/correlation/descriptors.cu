// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int tile_u{32};
constexpr int tile_v{8};
constexpr int threads{tile_u * tile_v};

struct GreyImages {
  View<const std::uint8_t, Device> left;
  View<const std::uint8_t, Device> right;
  const RoadPlane* plane;
};

// A tile of an image with what the windows at its border see.
struct Tile {
  static constexpr int columns{tile_u + 2 * short_census_half_u};
  static constexpr int rows{tile_v + 2 * short_census_half_v};

  std::int32_t road_start[rows];
  std::int32_t road_slope[rows];
  std::uint8_t grey[rows][columns];
};

// The descriptor's window around a pixel of the tile.
struct Window {
  const Tile& tile;
  int u;
  int v;
  STEREOGRID_HD int operator()(int i, int j) const {
    return tile.grey[v + short_census_half_v + j][u + short_census_half_u + i];
  }
};

// A row of the right image with its border repeated.
struct ClampedRow {
  const std::uint8_t* row;
  int width;
  STEREOGRID_HD int operator()(int u) const { return row[u < 0 ? 0 : (u < width ? u : width - 1)]; }
};

__device__ void load(const GreyImages& images, int image, Tile& tile) {
  const int width{images.left.width};
  const int height{images.left.height};
  const int thread{static_cast<int>(threadIdx.y) * tile_u + static_cast<int>(threadIdx.x)};
  const int first_u{static_cast<int>(blockIdx.x) * tile_u - short_census_half_u};
  const int first_v{static_cast<int>(blockIdx.y) * tile_v - short_census_half_v};
  if (thread < tile.rows) {
    const RoadRow road{road_row(*images.plane, clamped(first_v + thread, height))};
    tile.road_start[thread] = road.start;
    tile.road_slope[thread] = road.slope;
  }
  __syncthreads();
  for (int i{thread}; i < tile.rows * tile.columns; i += threads) {
    const int row{i / tile.columns};
    const int column{i % tile.columns};
    const int u{clamped(first_u + column, width)};
    const int v{clamped(first_v + row, height)};
    tile.grey[row][column] = image == 0   ? images.left(u, v)
                             : image == 1 ? images.right(u, v)
                                          : sheared_from(ClampedRow{images.right.row(v), width}, width, u,
                                                         {tile.road_start[row], tile.road_slope[row]});
  }
  __syncthreads();
}

// blockIdx.z: which of the three images.
__global__ void __launch_bounds__(threads)
    describe_images(GreyImages images, std::uint8_t mask, View<std::uint8_t, Device> left,
                    View<std::uint8_t, Device> right, View<std::uint8_t, Device> sheared_right) {
  __shared__ Tile tile;
  const int image{static_cast<int>(blockIdx.z)};
  load(images, image, tile);
  const int u{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  const int v{static_cast<int>(blockIdx.y * blockDim.y + threadIdx.y)};
  if (u >= left.width || v >= left.height) return;
  const Window window{tile, static_cast<int>(threadIdx.x), static_cast<int>(threadIdx.y)};
  auto* const to = image == 0 ? left.row(v) : (image == 1 ? right.row(v) : sheared_right.row(v));
  to[u] = static_cast<std::uint8_t>(short_census(window) & mask);
}

}  // namespace

void describe(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
              const RoadPlane* plane, int bits, DescribedOnDevice& described) {
  const dim3 grid{blocks_for(left.width, tile_u), blocks_for(left.height, tile_v), 3};
  launch(cuda, describe_images, grid, dim3{tile_u, tile_v}, 0, GreyImages{left, right, plane},
         static_cast<std::uint8_t>((1u << bits) - 1), described.left.view(), described.right.view(),
         described.sheared.view());
}

}  // namespace stereogrid
