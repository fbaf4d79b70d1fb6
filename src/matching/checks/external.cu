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
  const GroundRow row{road_plane(rig, *ground), v};
  for (int u{static_cast<int>(threadIdx.x)}; u < disparity.width; u += threads) {
    const float d{disparity(u, v)};
    const bool is_there{is_usable(d, config.disparities)};
    const SplitDisparity parts{labelled(d, test.is_on_road(d, row.at(u), row.x_of(u)))};
    obstacle(u, v) = is_there ? parts.obstacle : 0.0f;
    road(u, v) = is_there ? parts.road : 0.0f;
  }
}

__device__ SplitDisparity surface_at(int u, int v, View<const float, Device> disparity, const RoadPlane& plane,
                                     const HeightTest& test, const Relief<Device>& relief, int disparities) {
  const float d{disparity(u, v)};
  if (!is_usable(d, disparities)) return {0, 0};
  const float h{d - GroundRow{plane, v}.at(u, d, relief)};
  SurfaceEvidence around;
  for (int j{Max(v - surface_rows, 0)}; j <= Min(v + surface_rows, disparity.height - 1); ++j) {
    const GroundRow row{plane, j};
    for (int i{Max(u - surface_columns, 0)}; i <= Min(u + surface_columns, disparity.width - 1); ++i) {
      const float other{disparity(i, j)};
      if ((i == u && j == v) || !is_usable(other, disparities)) continue;
      around.add(other, other - row.at(i, other, relief), d, h);
    }
  }
  return surface_label(d, h, GroundRow{plane, v}.x_of(u), around, test);
}

__global__ void __launch_bounds__(threads)
    split_surface_rows(View<const float, Device> disparity, Rig rig, const Ground* ground, Relief<Device> relief,
                       MatchingConfig config, View<float, Device> obstacle, View<float, Device> road) {
  const int v{static_cast<int>(blockIdx.x)};
  const HeightTest test{rig, *ground, config};
  const RoadPlane plane{road_plane(rig, *ground)};
  for (int u{static_cast<int>(threadIdx.x)}; u < disparity.width; u += threads) {
    const SplitDisparity parts{surface_at(u, v, disparity, plane, test, relief, config.disparities)};
    obstacle(u, v) = parts.obstacle;
    road(u, v) = parts.road;
  }
}

}  // namespace

void split(Cuda& cuda, View<const float, Device> disparity, const Rig& rig, const Ground* ground,
           const MatchingConfig& config, DeviceMatches& matches) {
  launch(cuda, split_rows, dim3{static_cast<unsigned>(disparity.height)}, dim3{threads}, 0, disparity, rig, ground,
         config, matches.obstacle.view(), matches.road.view());
}

void split_surfaces(Cuda& cuda, View<const float, Device> disparity, const Rig& rig, const Ground* ground,
                    const Relief<Device>& relief, const MatchingConfig& config, DeviceMatches& matches) {
  launch(cuda, split_surface_rows, dim3{static_cast<unsigned>(disparity.height)}, dim3{threads}, 0, disparity, rig,
         ground, relief, config, matches.obstacle.view(), matches.road.view());
}

}  // namespace stereogrid
