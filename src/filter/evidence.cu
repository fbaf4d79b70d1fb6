// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/layers.cuh"

namespace stereogrid {
namespace {

constexpr int threads{64};
constexpr int blocks{256};

struct State {
  float* mass;
  float* scale;
  float* born_standing;
  float* born_moving;
};

// A cell per thread: they are few, and far apart.
__global__ void weigh_cells(const VelocityEvidence* evidence, const int* count, const float* axis_mps, int side,
                            int cells, State state, LayerPointers layers) {
  const int step{static_cast<int>(gridDim.x) * threads};
  for (int n{static_cast<int>(blockIdx.x) * threads + static_cast<int>(threadIdx.x)}; n < *count; n += step) {
    const VelocityEvidence one{evidence[n]};
    const auto mass = [&](int k) -> float& { return state.mass[static_cast<std::size_t>(k) * cells + one.cell]; };
    for (int k{0}; k < side * side; ++k) {
      const float born{k == side * side / 2 ? state.born_standing[one.cell] : state.born_moving[one.cell]};
      mass(k) = state.scale[one.cell] * mass(k) + born;
    }
    const WeighedCell cell{weigh(one, axis_mps, side, mass)};
    write_velocity(estimate_of(cell.sums), one.cell, layers);
    layers.moving[one.cell] = moving_share(layers.occupancy[one.cell], cell.standing);
    state.scale[one.cell] = 1;
    state.born_standing[one.cell] = state.born_moving[one.cell] = 0;
  }
}

}  // namespace

void weigh_velocities(Cuda& cuda, const FilterOnDevice& filter, const VelocityEvidence* evidence, const int* count,
                      FilterStateOnDevice& state, LayersOnDevice& layers) {
  launch(cuda, weigh_cells, blocks, threads, 0, evidence, count, filter.rounded_speed_mps.data(), filter.side,
         static_cast<int>(state.scale.size()),
         State{state.mass.data(), state.scale.data(), state.born_standing.data(), state.born_moving.data()},
         pointers(layers));
}

}  // namespace stereogrid
