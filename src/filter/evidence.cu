// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/blocks.cuh"
#include "filter/layers.cuh"

namespace stereogrid {
namespace {

constexpr int threads{64};
constexpr int blocks{256};

struct Weighing {
  const VelocityEvidence* evidence;
  const int* count;
  const float* axis_mps;
  int side;
  int cells;  ///< along a side of the window
  float each_moving;
  MovingFrom moving_from;
  int* starts;
};

// Tells a cell what has been measured. False: it makes the cell move, and its block has no masses.
__device__ bool weigh_cell(const Weighing& in, const VelocityEvidence& one, bool may_start, const JointPointers& state,
                           const LayerPointers& layers) {
  const int i{one.cell};
  const int x{i % in.cells};
  const int y{i / in.cells};
  const int block{BlockLayout{in.cells}.block_of(x, y)};
  const int slot{state.slots[block]};
  WeighedCell cell{};
  if (slot >= 0) {
    const int standstill{in.side * in.side / 2};
    float* const masses{state.mass + mass_index(slot, in.side * in.side, 0, x, y)};
    const auto mass = [&](int k) {
      return state.scale[i] * masses[k * block_cells] +
             (k == standstill ? state.born_standing[i] : state.born_moving[i]);
    };
    cell = weigh(one, in.axis_mps, in.side, mass, [&](int k, float m) { masses[k * block_cells] = m; });
    state.scale[i] = 1;
    state.born_standing[i] = state.born_moving[i] = 0;
  } else {
    const float standing{state.standing[i]};
    const float each{even_mass(in.each_moving, state.occupancy[i], standing)};
    cell = weigh_evenly(one, in.axis_mps, in.side, each, standing);
    if (may_start && is_moving(in.moving_from, state.occupancy[i], cell.standing)) {
      state.slots[block] = slot_wanted;
      return false;
    }
  }
  state.standing[i] = cell.standing;
  layers.moving[i] = moving_share(layers.occupancy[i], cell.standing);
  write_velocity(estimate_of(cell.sums), i, layers);
  return true;
}

// A cell per thread: they are few, and far apart.
__global__ void weigh_cells(Weighing in, JointPointers state, LayerPointers layers) {
  for (int n{static_cast<int>(blockIdx.x * threads + threadIdx.x)}; n < *in.count; n += blocks * threads) {
    in.starts[n] = weigh_cell(in, in.evidence[n], true, state, layers) ? 0 : 1;
  }
}

__global__ void weigh_starting_cells(Weighing in, JointPointers state, LayerPointers layers) {
  for (int n{static_cast<int>(blockIdx.x * threads + threadIdx.x)}; n < *in.count; n += blocks * threads) {
    if (in.starts[n] != 0) weigh_cell(in, in.evidence[n], false, state, layers);
  }
}

// A block of threads for each block of cells: those that have just been given a slot.
__global__ void fill_begun_blocks(Weighing in, JointPointers state) {
  const int x{static_cast<int>(blockIdx.x) * block_columns + static_cast<int>(threadIdx.x)};
  const int y{static_cast<int>(blockIdx.y) * block_rows + static_cast<int>(threadIdx.y)};
  if (x >= in.cells || y >= in.cells) return;
  const BlockLayout layout{in.cells};
  const int slot{state.slots[layout.block_of(x, y)]};
  if (slot < state.slots[layout.count() + 1]) return;
  const int i{y * in.cells + x};
  const int velocities{in.side * in.side};
  const float each{even_mass(in.each_moving, state.occupancy[i], state.standing[i])};
  float* const masses{state.mass + mass_index(slot, velocities, 0, x, y)};
  for (int k{0}; k < velocities; ++k) masses[k * block_cells] = k == velocities / 2 ? state.standing[i] : each;
  state.scale[i] = 1;
  state.born_standing[i] = state.born_moving[i] = 0;
}

}  // namespace

void weigh_velocities(Cuda& cuda, FilterOnDevice& filter, const VelocityEvidence* evidence, const int* count,
                      FilterStateOnDevice& state, LayersOnDevice& layers) {
  const int cells{state.occupancy.width()};
  const BlockLayout layout{cells};
  const Weighing in{evidence,
                    count,
                    filter.rounded_speed_mps.data(),
                    filter.side,
                    cells,
                    filter.each_moving,
                    filter.moving_from,
                    filter.starts.data()};
  const JointPointers pointers_of_state{joint_pointers(state)};
  launch(cuda, weigh_cells, blocks, threads, 0, in, pointers_of_state, pointers(layers));
  begin_wanted_blocks(cuda, filter, state);
  launch(cuda, fill_begun_blocks, dim3{static_cast<unsigned>(layout.across), static_cast<unsigned>(layout.along)},
         dim3{block_columns, block_rows}, 0, in, pointers_of_state);
  launch(cuda, weigh_starting_cells, blocks, threads, 0, in, pointers_of_state, pointers(layers));
}

}  // namespace stereogrid
