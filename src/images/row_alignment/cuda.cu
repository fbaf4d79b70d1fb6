// SPDX-License-Identifier: Apache-2.0
#include "images/row_alignment/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int block_width{16};
constexpr int block_height{8};

// A thread per offset_columns pixels of a row, which share an offset.
__global__ void align(View<const std::uint8_t, Device> right, const RowShift* shift,
                      View<std::uint8_t, Device> aligned) {
  const int begin{static_cast<int>(blockIdx.x * block_width + threadIdx.x) * offset_columns};
  const int v{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (begin >= right.width || v >= right.height) return;
  const int place{shift->is_identity != 0 ? v * 256 : place_256(shift->offsets, begin, v)};
  const auto row = [&](int k) { return right.row(k < 0 ? 0 : (k < right.height ? k : right.height - 1)); };
  const std::uint8_t* upper{row(place >> 8)};
  const std::uint8_t* lower{row((place >> 8) + 1)};
  const int end{begin + offset_columns < right.width ? begin + offset_columns : right.width};
  for (int u{begin}; u < end; ++u) aligned(u, v) = between_rows(upper[u], lower[u], place & 255);
}

__global__ void gather(View<const float, Device> obstacle, View<const float, Device> road,
                       View<float, Device> lattice) {
  const int i{static_cast<int>(blockIdx.x * block_width + threadIdx.x)};
  const int j{static_cast<int>(blockIdx.y * block_height + threadIdx.y)};
  if (i >= lattice.width || j >= lattice.height) return;
  const int u{MatchLattice::first_u + i * MatchLattice::step_u};
  const int v{MatchLattice::first_v + j * MatchLattice::step_v};
  const float on_road{road(u, v)};
  lattice(i, j) = on_road > 0 ? -on_road : obstacle(u, v);
}

dim3 blocks_over(int width, int height) {
  return {blocks_for(width, block_width), blocks_for(height, block_height)};
}

}  // namespace

void align_rows(Cuda& cuda, View<const std::uint8_t, Device> right, const RowShift* shift,
                View<std::uint8_t, Device> aligned) {
  const int pieces{(right.width + offset_columns - 1) / offset_columns};
  launch(cuda, align, blocks_over(pieces, right.height), dim3{block_width, block_height}, 0, right, shift, aligned);
}

void gather_lattice(Cuda& cuda, View<const float, Device> obstacle, View<const float, Device> road,
                    View<float, Device> lattice) {
  launch(cuda, gather, blocks_over(lattice.width, lattice.height), dim3{block_width, block_height}, 0, obstacle, road,
         lattice);
}

}  // namespace stereogrid
