// SPDX-License-Identifier: Apache-2.0
#include "backend/warp.cuh"
#include "filter/joint/blocks.cuh"
#include "filter/layers.cuh"

namespace stereogrid {
namespace {

constexpr int warps{4};
constexpr int blocks{512};

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

__device__ int lane_of_warp() {
  return static_cast<int>(threadIdx.x) % warp;
}

// `weigh` of evidence.hpp by a warp, to the bit: a lane for each row of the lattice, which are never more. All lanes
// have the result.
template <class Mass, class Keep>
__device__ WeighedCell weigh_by_rows(const Weighing& in, const VelocityEvidence& one, const Mass& mass,
                                     const Keep& keep) {
  const int row{lane_of_warp()};
  const bool has_row{row < in.side};
  const auto from = [](float value, int lane) { return __shfl_sync(whole_warp, value, lane); };
  const RowWeight weight{has_row ? weight_of_row(one, in.axis_mps, in.side, row, mass) : RowWeight{}};
  RowWeight all;
  for (int lane{0}; lane < in.side; ++lane) {
    all.before += from(weight.before, lane);
    all.after += from(weight.after, lane);
  }
  const WeighedRow weighed{has_row ? weigh_row(one, in.axis_mps, in.side, row, scale_of(all), mass, keep)
                                   : WeighedRow{}};
  WeighedCell cell{};
  for (int lane{0}; lane < in.side; ++lane) {
    cell.sums.add(in.axis_mps[lane],
                  {from(weighed.sums.mass, lane), from(weighed.sums.x, lane), from(weighed.sums.xx, lane)});
  }
  cell.standing = from(weighed.middle, in.side / 2);
  return cell;
}

// Weighs a cell whose block has masses.
__device__ WeighedCell weigh_masses(const Weighing& in, const VelocityEvidence& one, int slot,
                                    const JointPointers& state) {
  const int i{one.cell};
  const int velocities{in.side * in.side};
  float* const masses{state.mass + mass_index(slot, velocities, 0, i % in.cells, i / in.cells)};
  const float scale{state.scale[i]};
  const float birth_static{state.birth_static[i]};
  const float birth_moving{state.birth_moving[i]};
  const float standing{state.standing[i]};
  const float started{standing - standing_before(one, state.occupancy[i], standing)};
  const float started_each{started * in.each_moving};
  const auto mass = [&](int k) {
    const bool stands{k == velocities / 2};
    const float before{scale * masses[k * block_cells] + (stands ? birth_static : birth_moving)};
    return before + (stands ? -started : started_each);
  };
  const WeighedCell cell{weigh_by_rows(in, one, mass, [masses](int k, float m) { masses[k * block_cells] = m; })};
  __syncwarp();  // all lanes have read scale and birth
  if (lane_of_warp() == 0) {
    state.scale[i] = 1;
    state.birth_static[i] = state.birth_moving[i] = 0;
  }
  return cell;
}

// `weigh_evenly`: of one whose block has none.
__device__ WeighedCell weigh_even_cell(const Weighing& in, const VelocityEvidence& one, const JointPointers& state) {
  const float standing{standing_before(one, state.occupancy[one.cell], state.standing[one.cell])};
  const float each{even_mass(in.each_moving, state.occupancy[one.cell], standing)};
  const int standstill{in.side * in.side / 2};
  return weigh_by_rows(
      in, one, [&](int k) { return k == standstill ? standing : each; }, [](int, float) {});
}

// Updates a cell with a measured velocity. False: the cell begins to move, and its block has no masses. The evidence is
// copied, as it lies in pinned host memory.
__device__ bool weigh_cell(const Weighing& in, VelocityEvidence one, bool may_start, const JointPointers& state,
                           const LayerPointers& layers) {
  const int i{one.cell};
  if (is_ignored(one, state.age_s[i])) return true;
  const int block{BlockLayout{in.cells}.block_of(i % in.cells, i / in.cells)};
  const int slot{state.slots[block]};
  const WeighedCell cell{slot >= 0 ? weigh_masses(in, one, slot, state) : weigh_even_cell(in, one, state)};
  const bool starts{slot < 0 && may_start && is_moving(in.moving_from, state.occupancy[i], cell.standing)};
  __syncwarp();  // all lanes have read what the first one writes
  if (lane_of_warp() != 0) return !starts;
  if (starts) {
    state.standing[i] = standing_before(one, state.occupancy[i], state.standing[i]);
    state.slots[block] = slot_wanted;
    return false;
  }
  state.standing[i] = cell.standing;
  layers.moving[i] = moving_share(layers.occupancy[i], cell.standing);
  write_velocity(refined(one, in.axis_mps, in.side, cell), i, layers);
  return true;
}

// work(n) by a warp for each evidence.
template <class Work>
__device__ void for_evidence(const Weighing& in, const Work& work) {
  const int first{static_cast<int>(blockIdx.x) * warps + static_cast<int>(threadIdx.x) / warp};
  const int count{*in.count};  // host memory: one read
  for (int n{first}; n < count; n += blocks * warps) work(n);
}

__global__ void weigh_cells(Weighing in, JointPointers state, LayerPointers layers) {
  for_evidence(in, [&](int n) {
    const bool is_weighed{weigh_cell(in, in.evidence[n], true, state, layers)};
    if (lane_of_warp() == 0) in.starts[n] = is_weighed ? 0 : 1;
  });
}

__global__ void weigh_starting_cells(Weighing in, JointPointers state, LayerPointers layers) {
  for_evidence(in, [&](int n) {
    if (in.starts[n] != 0) weigh_cell(in, in.evidence[n], false, state, layers);
  });
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
  state.birth_static[i] = state.birth_moving[i] = 0;
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
  launch(cuda, weigh_cells, blocks, warps * warp, 0, in, pointers_of_state, pointers(layers));
  allocate_marked_blocks(cuda, filter, state);
  launch(cuda, fill_begun_blocks, dim3{static_cast<unsigned>(layout.across), static_cast<unsigned>(layout.along)},
         dim3{block_columns, block_rows}, 0, in, pointers_of_state);
  launch(cuda, weigh_starting_cells, blocks, warps * warp, 0, in, pointers_of_state, pointers(layers));
}

}  // namespace stereogrid
