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
template <int half_u, int half_v>
struct Tile {
  static constexpr int columns{tile_u + 2 * half_u};
  static constexpr int rows{tile_v + 2 * half_v};

  std::int32_t road_start[rows];
  std::int32_t road_slope[rows];
  std::uint8_t grey[rows][columns];
};

// The descriptor's window around a pixel of the tile.
template <int half_u, int half_v>
struct Window {
  const Tile<half_u, half_v>& tile;
  int u;
  int v;
  STEREOGRID_HD int operator()(int i, int j) const { return tile.grey[v + half_v + j][u + half_u + i]; }
};

struct Short {
  using Descriptor = std::uint8_t;
  static constexpr int half_u{short_census_half_u};
  static constexpr int half_v{short_census_half_v};
  template <class Pixel>
  STEREOGRID_HD static Descriptor of(const Pixel& pixel) {
    return short_census(pixel);
  }
};

struct Long {
  using Descriptor = std::uint32_t;
  static constexpr int half_u{census_half_u};
  static constexpr int half_v{census_half_v};
  template <class Pixel>
  STEREOGRID_HD static Descriptor of(const Pixel& pixel) {
    return census(pixel);
  }
};

// A row of the right image with its border repeated.
struct ClampedRow {
  const std::uint8_t* row;
  int width;
  STEREOGRID_HD int operator()(int u) const { return row[u < 0 ? 0 : (u < width ? u : width - 1)]; }
};

template <int half_u, int half_v>
__device__ void load(const GreyImages& images, int image, Tile<half_u, half_v>& tile) {
  const int width{images.left.width};
  const int height{images.left.height};
  const int thread{static_cast<int>(threadIdx.y) * tile_u + static_cast<int>(threadIdx.x)};
  const int first_u{static_cast<int>(blockIdx.x) * tile_u - half_u};
  const int first_v{static_cast<int>(blockIdx.y) * tile_v - half_v};
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
template <class Census>
__global__ void __launch_bounds__(threads)
    describe_images(GreyImages images, typename Census::Descriptor mask, View<typename Census::Descriptor, Device> left,
                    View<typename Census::Descriptor, Device> right,
                    View<typename Census::Descriptor, Device> sheared_right) {
  __shared__ Tile<Census::half_u, Census::half_v> tile;
  const int image{static_cast<int>(blockIdx.z)};
  load(images, image, tile);
  const int u{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  const int v{static_cast<int>(blockIdx.y * blockDim.y + threadIdx.y)};
  if (u >= left.width || v >= left.height) return;
  const Window<Census::half_u, Census::half_v> window{tile, static_cast<int>(threadIdx.x),
                                                      static_cast<int>(threadIdx.y)};
  auto* const to = image == 0 ? left.row(v) : (image == 1 ? right.row(v) : sheared_right.row(v));
  to[u] = static_cast<typename Census::Descriptor>(Census::of(window) & mask);
}

template <class Census>
void describe_all(Cuda& cuda, const GreyImages& images, typename Census::Descriptor mask,
                  DescribedOnDevice<typename Census::Descriptor>& described) {
  const dim3 grid{blocks_for(images.left.width, tile_u), blocks_for(images.left.height, tile_v), 3};
  launch(cuda, describe_images<Census>, grid, dim3{tile_u, tile_v}, 0, images, mask, described.left.view(),
         described.right.view(), described.sheared.view());
}

}  // namespace

void describe(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
              const RoadPlane* plane, int bits, DescribedOnDevice<std::uint8_t>& described) {
  describe_all<Short>(cuda, {left, right, plane}, static_cast<std::uint8_t>((1u << bits) - 1), described);
}

void describe(Cuda& cuda, View<const std::uint8_t, Device> left, View<const std::uint8_t, Device> right,
              const RoadPlane* plane, DescribedOnDevice<std::uint32_t>& described) {
  describe_all<Long>(cuda, {left, right, plane}, ~0u, described);
}

}  // namespace stereogrid
