// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"
#include "matching/lanes.cuh"

namespace stereogrid {
namespace {

constexpr int columns{64};  // columns of a block
constexpr int rows{16};
constexpr int half_window_max{20};
constexpr int threads{columns + 2 * half_window_max + 24};  // whole warps

// Every thread carries the sum of a column of the window down the rows.
__global__ void __launch_bounds__(threads)
    sum_contrasts(View<const std::uint8_t, Device> left, int half, int least, View<std::uint8_t, Device> textured) {
  __shared__ int sums[threads];
  const int thread{static_cast<int>(threadIdx.x)};
  const int first_u{static_cast<int>(blockIdx.x) * columns};
  const int first_v{static_cast<int>(blockIdx.y) * rows};
  const int end_v{min(first_v + rows, left.height)};
  const int column{clamped(first_u - half + thread, left.width)};
  const auto contrast = [&](int v) {
    const std::uint8_t* row{left.row(clamped(v, left.height))};
    const int difference{row[clamped(column + 1, left.width)] - row[clamped(column - 1, left.width)]};
    return difference < 0 ? -difference : difference;
  };
  int sum{0};
  for (int v{first_v - half}; v < first_v + half; ++v) sum += contrast(v);
  for (int v{first_v}; v < end_v; ++v) {
    sum += contrast(v + half);
    sums[thread] = sum;
    sum -= contrast(v - half);
    __syncthreads();
    if (thread < columns && first_u + thread < left.width) {
      int total{0};
      for (int i{0}; i <= 2 * half; ++i) total += sums[thread + i];
      textured(first_u + thread, v) = total >= least ? 1 : 0;
    }
    __syncthreads();
  }
}

}  // namespace

void find_texture(Cuda& cuda, View<const std::uint8_t, Device> left, int half_window, int least,
                  View<std::uint8_t, Device> textured) {
  launch(cuda, sum_contrasts, dim3{blocks_for(left.width, columns), blocks_for(left.height, rows)}, dim3{threads}, 0,
         left, half_window, least, textured);
}

}  // namespace stereogrid
