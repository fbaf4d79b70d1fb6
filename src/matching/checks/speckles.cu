// SPDX-License-Identifier: Apache-2.0
//
// Connected patches by union-find: every pixel points to another one of its patch with a smaller index, or to itself.
// The parts of 32 pixels of a row that a warp sees are joined by voting; only what goes beyond them needs atomics.
#include "matching/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int threads{128};

struct Patches {
  View<float, Device> obstacle;
  View<float, Device> road;
  View<float, Device> confidence;
  int* parents;
  int* sizes;

  // Disparity with the label as its sign, as in flag_surfaces. 0: no disparity.
  [[nodiscard]] __device__ float labelled(int u, int v) const { return obstacle(u, v) - road(u, v); }
  [[nodiscard]] __device__ int index(int u, int v) const { return v * obstacle.width + u; }
};

__device__ bool continues(float here, float neighbour) {
  const float step{here - neighbour};
  return (step < 0 ? -step : step) <= 1.0f && here * neighbour > 0;
}

struct Pixel {
  int u{static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x)};
  int v{static_cast<int>(blockIdx.y)};
  int lane{static_cast<int>(threadIdx.x) % 32};
};

__device__ int find(const int* parents, int pixel) {
  const volatile int* links{parents};  // others change them
  for (int parent{links[pixel]}; parent != pixel; parent = links[pixel]) pixel = parent;
  return pixel;
}

__device__ void join(int* parents, int a, int b) {
  for (;;) {
    a = find(parents, a);
    b = find(parents, b);
    if (a == b) return;
    if (a < b) {
      const int smaller{a};
      a = b;
      b = smaller;
    }
    const int before{atomicMin(parents + a, b)};
    if (before == a) return;
    a = before;  // another thread was faster
  }
}

// Points each pixel to the first one of its part, which gets the part's size.
__global__ void __launch_bounds__(threads) start_patches(Patches patches) {
  const Pixel pixel{};
  const bool inside{pixel.u < patches.obstacle.width};
  const float here{inside ? patches.labelled(pixel.u, pixel.v) : 0.0f};
  const float left{__shfl_up_sync(0xffffffffu, here, 1)};
  const bool begins{pixel.lane == 0 || !continues(here, left)};
  const unsigned beginnings{__ballot_sync(0xffffffffu, begins ? 1 : 0)};
  if (!inside) return;
  const int first{31 - __clz(static_cast<int>(beginnings & (0xffffffffu >> (31 - pixel.lane))))};
  const unsigned later{pixel.lane == 31 ? 0u : beginnings >> (pixel.lane + 1)};
  const int length{later == 0 ? 32 - pixel.lane : __ffs(static_cast<int>(later))};
  const int at{patches.index(pixel.u, pixel.v)};
  patches.parents[at] = at - (pixel.lane - first);
  patches.sizes[at] = begins && here != 0 ? length : 0;
}

// Joins parts that touch; not where the pixel to the left has joined the same two.
__global__ void __launch_bounds__(threads) join_patches(Patches patches) {
  const Pixel pixel{};
  const int u{pixel.u};
  const int v{pixel.v};
  if (u >= patches.obstacle.width) return;
  const float here{patches.labelled(u, v)};
  if (here == 0) return;
  const int at{patches.index(u, v)};
  const float left{u > 0 ? patches.labelled(u - 1, v) : 0.0f};
  if (pixel.lane == 0 && continues(here, left)) join(patches.parents, at, at - 1);
  if (v == 0) return;
  const float above{patches.labelled(u, v - 1)};
  if (!continues(here, above)) return;
  const float above_left{u > 0 ? patches.labelled(u - 1, v - 1) : 0.0f};
  if (continues(here, left) && continues(left, above_left) && continues(above, above_left)) return;
  join(patches.parents, at, at - patches.obstacle.width);
}

__global__ void __launch_bounds__(threads) sum_patches(Patches patches) {
  const Pixel pixel{};
  if (pixel.u >= patches.obstacle.width) return;
  const int at{patches.index(pixel.u, pixel.v)};
  const int size{patches.sizes[at]};
  if (size == 0 || patches.parents[at] == at) return;
  const int root{find(patches.parents, at)};
  static_cast<volatile int*>(patches.parents)[at] = root;  // find() of other threads reads it
  atomicAdd(patches.sizes + root, size);
}

__global__ void __launch_bounds__(threads) remove_small(Patches patches, SpeckleSizes smallest) {
  const Pixel pixel{};
  const int u{pixel.u};
  const int v{pixel.v};
  if (u >= patches.obstacle.width || patches.labelled(u, v) == 0) return;
  const int least{patches.obstacle(u, v) > 0 ? smallest.obstacle_px : smallest.road_px};
  if (patches.sizes[find(patches.parents, patches.index(u, v))] >= least) return;
  patches.obstacle(u, v) = patches.road(u, v) = patches.confidence(u, v) = 0.0f;
}

}  // namespace

void remove_speckles(Cuda& cuda, const SpeckleSizes& smallest, View<int, Device> parents, View<int, Device> sizes,
                     DeviceMatches& matches) {
  if (smallest.remove_nothing()) return;
  const Patches patches{matches.obstacle.view(), matches.road.view(), matches.confidence.view(), parents.data,
                        sizes.data};
  const dim3 grid{blocks_for(parents.width, threads), static_cast<unsigned>(parents.height)};
  launch(cuda, start_patches, grid, dim3{threads}, 0, patches);
  launch(cuda, join_patches, grid, dim3{threads}, 0, patches);
  launch(cuda, sum_patches, grid, dim3{threads}, 0, patches);
  launch(cuda, remove_small, grid, dim3{threads}, 0, patches, smallest);
}

}  // namespace stereogrid
