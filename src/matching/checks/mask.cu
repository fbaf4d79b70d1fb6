// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int threads{128};

struct MaskedImages {
  View<float, Device> obstacle;
  View<float, Device> road;
  View<float, Device> confidence;
};

// A block clears a row.
__global__ void __launch_bounds__(threads)
    clear_rows(View<const std::uint8_t, Device> masked, int first_row, MaskedImages images) {
  const int v{first_row + static_cast<int>(blockIdx.x)};
  for (int u{static_cast<int>(threadIdx.x)}; u < masked.width; u += threads) {
    if (masked(u, v) != 0) images.obstacle(u, v) = images.road(u, v) = images.confidence(u, v) = 0.0f;
  }
}

}  // namespace

void clear_masked(Cuda& cuda, const PixelMask& mask, View<const std::uint8_t, Device> masked, DeviceMatches& matches) {
  if (mask.empty()) return;
  launch(cuda, clear_rows, dim3{static_cast<unsigned>(mask.end_row() - mask.first_row())}, dim3{threads}, 0, masked,
         mask.first_row(), MaskedImages{matches.obstacle.view(), matches.road.view(), matches.confidence.view()});
}

}  // namespace stereogrid
