// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/layers.cuh"
#include "filter/strip.cuh"

#include <cmath>
#include <vector>

namespace stereogrid {
namespace {

constexpr int prepare_threads{256};

struct StateBefore {
  const float* mass;
  const float* scale;
  const float* born_standing;
  const float* born_moving;
  const float* occupancy;
  const float* age_s;
};
struct StateAfter {
  float* mass;
  float* scale;
  float* born_standing;
  float* born_moving;
  float* occupancy;
  float* age_s;
};
// --- before: what prediction reads of each cell, and where the masses of each velocity come from ---------------------

// Of the prepared numbers, x is the scale, w the standing mass after the noise, z what each moving velocity gains;
// y is what was born of each moving velocity (joint), or P(still occupied) (tay2008).
template <FilterModel model>
__global__ void prepare(const FilterMotion* motion, const double* speed_mps, StateBefore before, int cells,
                        Antecedents* from, float4* prepared) {
  const int i{static_cast<int>(blockIdx.x * prepare_threads + threadIdx.x)};
  const FilterStep& step{motion->step};
  if (i < step.velocities()) {
    from[i] = antecedents(speed_mps[i % step.side] * motion->cells_per_mps,
                          speed_mps[i / step.side] * motion->cells_per_mps, motion->moved_x, motion->moved_y);
  }
  const int count{cells * cells};
  if (i >= count) return;
  const float arrived{before.mass[static_cast<std::size_t>(step.standstill()) * count + i]};
  const float standing{before.scale[i] * arrived + before.born_standing[i]};
  constexpr bool joint{model == FilterModel::joint};
  const float all{joint ? before.occupancy[i] : 1.0f};
  prepared[i] = make_float4(before.scale[i], joint ? before.born_moving[i] : still_occupied(step, before.occupancy[i]),
                            gained_by_moving(step, all, standing), disturbed_standing(step, all, standing));
}

// --- the step ---------------------------------------------------------------------------------------------------

// What the filter says about a cell after it.
struct Cell {
  float scale;
  float born_standing;
  float born_moving;
  float occupancy;
  float standing;
  VelocitySums sums;
};

template <FilterModel model>
__device__ Cell updated_cell(const FilterStep& step, const StripSums& strip, int r, float age_s, Likelihood likelihood,
                             CellView view) {
  const int lane{static_cast<int>(threadIdx.x)};
  const VelocitySums total{total_of(strip, r, lane)};
  const float standing{strip.standing[r][lane]};
  if constexpr (model == FilterModel::joint) {
    const JointUpdate update{joint_update(step, total.mass, age_s, likelihood, view)};
    return {update.scale,
            update.born_standing,
            update.born_moving,
            update.occupancy,
            update.scale * standing + update.born_standing,
            updated(step, update, total)};
  } else {
    const float scale{1 / strip.all[r][lane]};
    return {scale, 0, 0, scale * total.mass, scale * standing, total};
  }
}

__device__ void write(const Cell& cell, float age_s, int i, const StateAfter& after, const LayerPointers& layers) {
  after.scale[i] = cell.scale;
  after.born_standing[i] = cell.born_standing;
  after.born_moving[i] = cell.born_moving;
  after.occupancy[i] = layers.occupancy[i] = cell.occupancy;
  after.age_s[i] = layers.age_s[i] = age_s;
  write_velocity(estimate_of(cell.sums), i, layers);
  layers.moving[i] = moving_share(cell.occupancy, cell.standing);
}

template <FilterModel model>
__global__ void __launch_bounds__(warps_max* warp, 4)
    filter_cells(const FilterMotion* motion, Lattice lattice, const float* likelihoods, const float4* prepared,
                 View<const float, Device> observed, StateBefore before, StateAfter after, LayerPointers layers) {
  __shared__ StripSums shared;
  const int cells{observed.width};
  const int x{static_cast<int>(blockIdx.x) * strip_columns + static_cast<int>(threadIdx.x)};
  const int y{static_cast<int>(blockIdx.y) * strip_rows};
  const bool is_written{threadIdx.x < strip_columns && x < cells};
  const int moved_x{motion->moved_x};
  const int moved_y{motion->moved_y};
  const auto is_known = [&](int row) {
    return x + moved_x >= 0 && x + moved_x < cells && row + moved_y >= 0 && row + moved_y < cells;
  };
  Strip<model> strip{motion->step, before.mass, prepared, cells, x, y, is_written, {}, {}};
  for (int r{0}; r < strip_rows; ++r) {
    strip.is_known[r] = is_known(y + r);
    if (is_written && y + r < cells) strip.likelihood[r] = likelihood_of(likelihoods, observed(x, y + r));
  }
  const int warps{static_cast<int>(blockDim.y)};
  const int side{strip.step.side};
  for (int first{0}; first < side; first += warps) {
    const int w{static_cast<int>(threadIdx.y)};
    if (first + w < side) strip.run_row(lattice, first + w, after.mass, shared.of_row[w], shared);
    __syncthreads();
    add_rows(lattice, first, side - first < warps ? side - first : warps, shared);
    __syncthreads();
  }
  for (int r{static_cast<int>(threadIdx.y)}; r < strip_rows && is_written && y + r < cells; r += warps) {
    const float seen{observed(x, y + r)};
    const float age_s{is_known(y + r) ? before.age_s[(y + r + moved_y) * cells + x + moved_x] : INFINITY};
    const bool is_seen{stereogrid::is_known(seen)};
    write(updated_cell<model>(strip.step, shared, r, age_s, likelihood_of(likelihoods, seen),
                              view_of(strip.step, x, y + r)),
          is_seen ? 0.0f : age_s + motion->dt_s, (y + r) * cells + x, after, layers);
  }
}

template <FilterModel model>
__global__ void begin_anew(const FilterMotion* motion, StateAfter state, int count) {
  const int i{static_cast<int>(blockIdx.x * prepare_threads + threadIdx.x)};
  if (i >= count) return;
  const FilterStep& step{motion->step};
  const float mass{model == FilterModel::joint ? 0.5f : 1.0f};
  for (int k{0}; k < step.velocities(); ++k) {
    state.mass[static_cast<std::size_t>(k) * count + i] = mass * prior_of(step, k);
  }
  state.scale[i] = 1;
  state.born_standing[i] = state.born_moving[i] = 0;
  state.occupancy[i] = 0.5f;
  state.age_s[i] = INFINITY;
}

StateBefore pointers(const FilterStateOnDevice& state) {
  return {state.mass.data(),        state.scale.data(),     state.born_standing.data(),
          state.born_moving.data(), state.occupancy.data(), state.age_s.data()};
}
StateAfter pointers(FilterStateOnDevice& state) {
  return {state.mass.data(),        state.scale.data(),     state.born_standing.data(),
          state.born_moving.data(), state.occupancy.data(), state.age_s.data()};
}
// As many as share the rows of the lattice evenly.
int warps_for(int side) {
  const int rounds{(side + warps_max - 1) / warps_max};
  return (side + rounds - 1) / rounds;
}

// Of the lattice's columns, and of its rows.
std::vector<double> speeds(const std::vector<Point2>& lattice) {
  std::vector<double> result;
  for (std::size_t i{0}; i * i < lattice.size(); ++i) result.push_back(lattice[i].x);
  return result;
}

template <FilterModel model>
void step(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
          const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers) {
  const int cells{observed.width};
  const int most{cells * cells > filter.side * filter.side ? cells * cells : filter.side * filter.side};
  launch(cuda, prepare<model>, blocks_for(most, prepare_threads), prepare_threads, 0, motion, filter.speed_mps.data(),
         pointers(before), cells, filter.from.data(), filter.prepared.data());
  launch(cuda, filter_cells<model>, dim3{blocks_for(cells, strip_columns), blocks_for(cells, strip_rows)},
         dim3{warp, static_cast<unsigned>(warps_for(filter.side))}, 0, motion,
         Lattice{filter.rounded_speed_mps.data(), filter.from.data()}, filter.likelihood.data(), filter.prepared.data(),
         observed, pointers(before), pointers(after), pointers(layers));
}

}  // namespace

FilterMotion filter_motion(const FilterInput& input, const GridGeometry& before) {
  const Scroll scroll{scroll_between(before, input.geometry)};
  return {step_of(input), static_cast<float>(input.dt_s), input.dt_s / input.geometry.cell_size_m, scroll.x, scroll.y};
}

FilterStateOnDevice::FilterStateOnDevice(int cells, int velocities)
    : mass{static_cast<std::size_t>(velocities) * static_cast<std::size_t>(cells * cells)},
      scale{cells, cells},
      born_standing{cells, cells},
      born_moving{cells, cells},
      occupancy{cells, cells},
      age_s{cells, cells} {}

FilterOnDevice::FilterOnDevice(Cuda& cuda, const FilterConfig& config, const FilterTables& tables, int cells)
    : model{config.model},
      side{static_cast<int>(speeds(tables.lattice).size())},
      likelihood{tables.likelihood.size()},
      speed_mps{static_cast<std::size_t>(side)},
      rounded_speed_mps{static_cast<std::size_t>(side)},
      from{tables.lattice.size()},
      prepared{cells, cells} {
  const std::vector<double> of_lattice{speeds(tables.lattice)};
  const std::vector<float> rounded(of_lattice.begin(), of_lattice.end());
  upload(cuda, of_lattice.data(), of_lattice.size(), speed_mps.data());
  upload(cuda, rounded.data(), rounded.size(), rounded_speed_mps.data());
  upload(cuda, tables.likelihood.data(), tables.likelihood.size(), likelihood.data());
  cuda.synchronize();  // the tables are the caller's
}

void reset(Cuda& cuda, const FilterOnDevice& filter, const FilterMotion* motion, FilterStateOnDevice& state) {
  const int count{static_cast<int>(state.scale.size())};
  const auto kernel =
      filter.model == FilterModel::joint ? begin_anew<FilterModel::joint> : begin_anew<FilterModel::tay2008>;
  launch(cuda, kernel, blocks_for(count, prepare_threads), prepare_threads, 0, motion, pointers(state), count);
}

void filter(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
            const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers) {
  if (filter.model == FilterModel::joint) {
    step<FilterModel::joint>(cuda, filter, motion, observed, before, after, layers);
  } else {
    step<FilterModel::tay2008>(cuda, filter, motion, observed, before, after, layers);
  }
}

}  // namespace stereogrid
