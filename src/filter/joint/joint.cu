// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "backend/warp.cuh"
#include "filter/joint/blocks.cuh"
#include "filter/layers.cuh"

namespace stereogrid {
namespace {

constexpr int row_threads{128};
constexpr int warp_rows{warp / block_columns};
constexpr int lattice_warps_max{16};

// Input of the prediction for each cell, the source cells of each velocity's masses, and the moving cells. A block of
// threads for each block of cells. Components of the prepared numbers: x scale, y birth mass of each moving velocity, z
// gain of each of them, w standing mass after the noise.
__global__ void prepare(const FilterMotion* motion, const double* speed_mps, JointPointers before, int cells,
                        Antecedents* from, float4* prepared, float* even, CellBox* moving) {
  __shared__ CellBox box;
  const FilterStep& step{motion->step};
  const int block{static_cast<int>(blockIdx.y * gridDim.x + blockIdx.x)};
  const int tid{static_cast<int>(threadIdx.y) * block_columns + static_cast<int>(threadIdx.x)};
  const int threads{static_cast<int>(gridDim.x * gridDim.y) * block_cells};
  for (int k{block * block_cells + tid}; k < step.velocities(); k += threads) {
    from[k] = antecedents(speed_mps[k % step.side] * motion->cells_per_mps,
                          speed_mps[k / step.side] * motion->cells_per_mps, motion->moved_x, motion->moved_y);
  }
  const int x{static_cast<int>(blockIdx.x) * block_columns + static_cast<int>(threadIdx.x)};
  const int y{static_cast<int>(blockIdx.y) * block_rows + static_cast<int>(threadIdx.y)};
  const bool has_some{is_followed(step, BlockLayout{cells}.cells_of(block), motion->moved_x, motion->moved_y)};
  if (tid == 0) box = {cells, cells, -1, -1};
  __syncthreads();
  if (x < cells && y < cells) {
    const int i{y * cells + x};
    const float all{before.occupancy[i]};
    const float standing{before.standing[i]};
    const float gained{gained_by_moving(step, all, standing)};
    prepared[i] = make_float4(before.scale[i], before.birth_moving[i], gained, disturbed_standing(step, all, standing));
    even[i] = disturbed(step.kept_moving, even_mass(step.each_moving, all, standing), gained);
    if (has_some && is_moving(step.moving_from, all, standing) && !is_as_unseen(step, all, standing, before.age_s[i])) {
      atomicMin(&box.x_first, x);
      atomicMin(&box.y_first, y);
      atomicMax(&box.x_last, x);
      atomicMax(&box.y_last, y);
    }
  }
  __syncthreads();
  if (tid == 0) moving[block] = box;
}

// A thread per cell of the step before: FilterWorkspace::spread.
__global__ void spread_along_x(const FilterMotion* motion, const Antecedents* from, const float* even, int cells,
                               float* spread) {
  const int i{static_cast<int>(blockIdx.x * row_threads + threadIdx.x)};
  if (i >= cells * cells) return;
  const int x{i % cells};
  const float* const row{even + i - x};
  const auto at = [&](int ax) { return ax >= 0 && ax < cells ? row[ax] : even_outside(motion->step); };
  float sum{0};
  for (int n{0}; n < motion->step.side; ++n) {
    sum += between(at(x + from[n].ix), at(x + from[n].ix + 1), from[n].fx);
  }
  spread[i] = sum;
}

// A cell of the window now.
struct Target {
  const FilterStep& step;
  const Antecedents* from;
  const float4* prepared;
  const float* even;
  const float* spread;
  const CellBox* moving;
  JointPointers before;
  int cells;
  int x;
  int y;

  __device__ bool inside(int ax, int ay) const { return ax >= 0 && ax < cells && ay >= 0 && ay < cells; }

  // Mass of the moving velocity k after the noise.
  __device__ float mass(int k, int ax, int ay) const {
    if (!inside(ax, ay)) return even_outside(step);
    const int block{BlockLayout{cells}.block_of(ax, ay)};
    const int slot{moving[block].is_empty() ? -1 : before.slots[block]};
    if (slot < 0) return even[ay * cells + ax];
    const float4 of_cell{prepared[ay * cells + ax]};
    const float arrived{before.mass[mass_index(slot, step.velocities(), k, ax, ay)]};
    return disturbed(step.kept_moving, of_cell.x * arrived + of_cell.y, of_cell.z);
  }

  __device__ float gathered(int k) const {
    const Antecedents a{from[k]};
    const int ax{x + a.ix};
    const int ay{y + a.iy};
    return between(between(mass(k, ax, ay), mass(k, ax + 1, ay), a.fx),
                   between(mass(k, ax, ay + 1), mass(k, ax + 1, ay + 1), a.fx), a.fy);
  }

  // Spread mass of a row outside the window.
  __device__ float spread_outside() const {
    float sum{0};
    for (int i{0}; i < step.side; ++i) sum += between(even_outside(step), even_outside(step), from[i].fx);
    return sum;
  }

  // `here`: the cell of the step before at this place.
  __device__ float arrived_evenly(int here) const {
    const auto at = [&](int ay) { return ay >= 0 && ay < cells ? spread[ay * cells + x] : spread_outside(); };
    float sum{0};
    for (int j{0}; j < step.side; ++j) {
      const Antecedents a{from[j * step.side]};
      sum += between(at(y + a.iy), at(y + a.iy + 1), a.fy);
    }
    return even_arrived(step.each_moving, sum, even[here]);
  }
};

struct Observed {
  float age_before_s;
  bool is_unseen;  ///< was as unseen_cell, and nothing is observed
  Likelihood likelihood;
  CellView view;
};

// Standing mass that arrives in a cell. `here`: the cell of the last state at this place; negative: new in the window.
__device__ float arrived_standing(const Target& target, int here) {
  return here < 0 ? new_to_the_window(target.step).standing : target.prepared[here].w;
}

// The masses of row j of the lattice that arrive in a cell whose block has masses.
__device__ LatticeRowSums<float> arrive(const Target& target, const float* speed_mps, int here, int slot, int j,
                                        float* mass_after) {
  const FilterStep& step{target.step};
  LatticeRowSums<float> row;
  for (int i{0}; i < step.side; ++i) {
    const int k{j * step.side + i};
    const float mass{k == step.standstill() ? arrived_standing(target, here)
                     : here < 0             ? new_to_the_window(step).each
                                            : target.gathered(k)};
    row.add(speed_mps[i], mass);
    mass_after[mass_index(slot, step.velocities(), k, target.x, target.y)] = mass;
  }
  return row;
}

// Updates a cell whose block has masses, from the sums of the lattice's rows.
__device__ FilteredCell filter_masses(const Target& target, const float* speed_mps, int here, const Observed& observed,
                                      const LatticeRowSums<float>* of_row, const JointPointers& after) {
  const FilterStep& step{target.step};
  VelocitySums sums;
  for (int j{0}; j < step.side; ++j) sums.add(speed_mps[j], of_row[j * warp]);
  const JointUpdate update{joint_update(step, sums.mass, arrived_standing(target, here), observed.age_before_s,
                                        observed.likelihood, observed.view)};
  const int i{target.y * target.cells + target.x};
  after.scale[i] = update.scale;
  after.birth_static[i] = update.birth_static;
  after.birth_moving[i] = update.birth_moving;
  return {update.occupancy, update.scale * arrived_standing(target, here) + update.birth_static,
          updated(step, update, sums)};
}

__device__ FilteredCell filter_evenly(const Target& target, int here, const Observed& observed) {
  const EvenArrived arrived{here < 0 ? new_to_the_window(target.step)
                                     : EvenArrived{target.prepared[here].w, target.arrived_evenly(here)}};
  return updated_evenly(target.step, arrived.standing, arrived.each, observed.age_before_s, observed.is_unseen,
                        observed.likelihood, observed.view);
}

struct Tables {
  const float* speed_mps;
  const float* likelihoods;
};

// The lanes of a warp are some rows of a block of cells; the warps of a block of threads share the rows of the lattice.
__global__ void __launch_bounds__(warp* lattice_warps_max)
    filter_cells(const FilterMotion* motion, Tables tables, const Antecedents* from, const float4* prepared,
                 const float* even, const float* spread, const CellBox* moving, View<const float, Device> observed,
                 JointPointers before, JointPointers after, LayerPointers layers) {
  const int cells{observed.width};
  const int lane{static_cast<int>(threadIdx.x)};
  const int x{static_cast<int>(blockIdx.x) * block_columns + lane % block_columns};
  const int y{static_cast<int>(blockIdx.y) * warp_rows + lane / block_columns};
  const Target target{motion->step, from, prepared, even, spread, moving, before, cells, x, y};
  const bool is_cell{x < cells && y < cells};
  const int ax{x + motion->moved_x};
  const int ay{y + motion->moved_y};
  const int here{target.inside(ax, ay) ? ay * cells + ax : -1};
  // all cells of this block of threads belong to one block, the first of them lies in the window
  const int slot{after.slots[BlockLayout{cells}.block_of(x - lane % block_columns, y - lane / block_columns)]};
  LatticeRowSums<float>* const of_row{dynamic_shared<LatticeRowSums<float>>() + lane};
  for (int j{static_cast<int>(threadIdx.y)}; j < target.step.side && slot >= 0 && is_cell; j += blockDim.y) {
    of_row[j * warp] = arrive(target, tables.speed_mps, here, slot, j, after.mass);
  }
  __syncthreads();
  if (threadIdx.y != 0 || !is_cell) return;
  const float seen{observed(x, y)};
  const bool was_unseen{here < 0 ||
                        is_as_unseen(motion->step, before.occupancy[here], before.standing[here], before.age_s[here])};
  const Observed what{here < 0 ? INFINITY : before.age_s[here], seen == 0.5f && was_unseen,
                      likelihood_of(tables.likelihoods, seen), view_of(motion->step, x, y)};
  const FilteredCell cell{slot < 0 ? filter_evenly(target, here, what)
                                   : filter_masses(target, tables.speed_mps, here, what, of_row, after)};
  const int i{y * cells + x};
  after.occupancy[i] = layers.occupancy[i] = cell.occupancy;
  after.standing[i] = cell.standing;
  after.age_s[i] = layers.age_s[i] = is_known(seen) ? 0.0f : what.age_before_s + motion->dt_s;
  layers.moving[i] = moving_share(cell.occupancy, cell.standing);
  write_velocity(estimate_of(cell.sums), i, layers);
}

}  // namespace

void filter_joint(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
                  const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers) {
  const int cells{observed.width};
  const BlockLayout layout{cells};
  const dim3 blocks{static_cast<unsigned>(layout.across), static_cast<unsigned>(layout.along)};
  const dim3 block{block_columns, block_rows};
  launch(cuda, prepare, blocks, block, 0, motion, filter.speed_mps.data(), joint_pointers(before), cells,
         filter.from.data(), filter.prepared.data(), filter.even.data(), filter.moving.data());
  begin_reached_blocks(cuda, filter, motion, after);
  launch(cuda, spread_along_x, blocks_for(cells * cells, row_threads), row_threads, 0, motion, filter.from.data(),
         filter.even.data(), cells, filter.spread.data());
  const int lattice_warps{filter.side < lattice_warps_max ? filter.side : lattice_warps_max};
  launch(cuda, filter_cells, dim3{blocks.x, blocks_for(cells, warp_rows)},
         dim3{warp, static_cast<unsigned>(lattice_warps)}, sizeof(LatticeRowSums<float>) * warp * filter.side, motion,
         Tables{filter.rounded_speed_mps.data(), filter.likelihood.data()}, filter.from.data(), filter.prepared.data(),
         filter.even.data(), filter.spread.data(), filter.moving.data(), observed, joint_pointers(before),
         joint_pointers(after), pointers(layers));
}

}  // namespace stereogrid
