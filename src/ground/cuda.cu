// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ground/cuda.hpp"

namespace stereogrid {
namespace {

constexpr int gather_threads{128};

__global__ void trust(const GroundPrior* prior, Ground* ground, int* lost) {
  Ground trusted{prior->previous};
  trusted.estimated = false;
  *ground = trusted;
  *lost = 0;
}

// --- the lattice: a thread per pixel of it --------------------------------------------------------------------------

__device__ void count_distance(float disparity, double expected_px, int* counts) {
  if (!(disparity > 0)) return;
  const double bin{distance_bin(disparity - expected_px)};
  if (bin >= 0 && bin < distance_bins) atomicAdd(&counts[static_cast<int>(bin)], 1);
}

__global__ void gather(View<const float, Device> obstacle, View<const float, Device> road, const GroundPrior* prior,
                       View<float, Device> residual, int* distances) {
  __shared__ int counts[distance_bins];
  for (int i{static_cast<int>(threadIdx.x)}; i < distance_bins; i += gather_threads) counts[i] = 0;
  __syncthreads();
  const int i{static_cast<int>(blockIdx.x * gather_threads + threadIdx.x)};
  const int j{static_cast<int>(blockIdx.y)};
  if (i < residual.width) {
    const int u{i * lattice_px + lattice_px / 2};
    const int v{j * lattice_px + lattice_px / 2};
    const double expected_px{prior->expected.disparity(u, v)};
    const float disparity{road(u, v)};
    residual(i, j) =
        disparity > 0 && j >= prior->first_row ? static_cast<float>(disparity - expected_px) : no_ground_sample;
    if (j >= prior->horizon_row) {
      count_distance(disparity, expected_px, counts);
      count_distance(obstacle(u, v), expected_px, counts);
    }
  }
  __syncthreads();
  for (int k{static_cast<int>(threadIdx.x)}; k < distance_bins; k += gather_threads) {
    if (counts[k] > 0) atomicAdd(&distances[k], counts[k]);
  }
}

int lattice_size(int pixels) {
  return (pixels + lattice_px / 2 - 1) / lattice_px;
}

}  // namespace

GroundOnDevice::GroundOnDevice(int width, int height)
    : residual{lattice_size(width), lattice_size(height)}, distances{distance_bins} {}

GroundPrior prior_of(const Rig& rig, const GroundConfig& config, const Ground& previous, double dt_s) {
  const Ground before{predicted(rig, config, previous, dt_s)};
  const RoadPlane expected{road_plane(rig, before)};
  return {previous,
          before,
          expected,
          carried(numbers_by_ground(rig, before), covariance_of(before)),
          lattice_row(first_ground_row(rig, expected), rig.height_px),
          lattice_row(horizon_row(rig, before), rig.height_px)};
}

void estimate_ground(Cuda& cuda, const Rig& rig, const GroundConfig& config, View<const float, Device> obstacle,
                     View<const float, Device> road, const GroundPrior* prior, GroundOnDevice& space, Ground* ground,
                     int* lost) {
  if (!config.estimate) return launch(cuda, trust, 1, 1, 0, prior, ground, lost);
  const View<float, Device> residual{space.residual.view()};
  launch(cuda, gather, dim3{blocks_for(residual.width, gather_threads), static_cast<unsigned>(residual.height)},
         gather_threads, 0, obstacle, road, prior, residual, space.distances.data());
  fit_ground(cuda, rig, config, prior, space, ground, lost);
}

}  // namespace stereogrid
