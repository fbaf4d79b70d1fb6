// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "matching/checks/external.hpp"
#include "matching/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int threads{128};

// Splits a row per block; the plane is read from device memory.
__global__ void __launch_bounds__(threads)
    split_rows(View<const float, Device> disparity, Rig rig, const Ground* ground, MatchingConfig config,
               View<float, Device> obstacle, View<float, Device> road) {
  const int v{static_cast<int>(blockIdx.x)};
  const HeightTest test{rig, *ground, config};
  const SplitRow row{road_plane(rig, *ground), v};
  for (int u{static_cast<int>(threadIdx.x)}; u < disparity.width; u += threads) {
    const SplitDisparity parts{row.at(u, disparity(u, v), test, config.disparities)};
    obstacle(u, v) = parts.obstacle;
    road(u, v) = parts.road;
  }
}

__global__ void __launch_bounds__(threads) keep_usable(View<const float, Device> disparity, int disparities,
                                                       View<float, Device> obstacle, View<float, Device> road) {
  const int v{static_cast<int>(blockIdx.x)};
  for (int u{static_cast<int>(threadIdx.x)}; u < disparity.width; u += threads) {
    const float d{disparity(u, v)};
    obstacle(u, v) = is_usable(d, disparities) ? d : 0.0f;
    road(u, v) = 0.0f;
  }
}

}  // namespace

void split(Cuda& cuda, View<const float, Device> disparity, const Rig& rig, const Ground* ground,
           const MatchingConfig& config, DeviceMatches& matches) {
  launch(cuda, split_rows, dim3{static_cast<unsigned>(disparity.height)}, dim3{threads}, 0, disparity, rig, ground,
         config, matches.obstacle.view(), matches.road.view());
}

void leave_whole(Cuda& cuda, View<const float, Device> disparity, const MatchingConfig& config,
                 DeviceMatches& matches) {
  launch(cuda, keep_usable, dim3{static_cast<unsigned>(disparity.height)}, dim3{threads}, 0, disparity,
         config.disparities, matches.obstacle.view(), matches.road.view());
}

}  // namespace stereogrid
