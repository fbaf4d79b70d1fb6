// SPDX-License-Identifier: Apache-2.0
#include "filter/joint/blocks.cuh"
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
  const float* occupancy;
  const float* age_s;
};
struct StateAfter {
  float* mass;
  float* scale;
  float* occupancy;
  float* age_s;
};

// Input of the prediction for each cell, and the source cells of each velocity's masses. Components of the prepared
// numbers: x scale, y P(still occupied), z gain of each moving velocity, w standing mass after the noise.
__global__ void prepare_tay(const FilterMotion* motion, const double* speed_mps, StateBefore before, int cells,
                            Antecedents* from, float4* prepared) {
  const int i{static_cast<int>(blockIdx.x * prepare_threads + threadIdx.x)};
  const FilterStep& step{motion->step};
  if (i < step.velocities()) {
    from[i] = antecedents(speed_mps[i % step.side] * motion->cells_per_mps,
                          speed_mps[i / step.side] * motion->cells_per_mps, motion->moved_x, motion->moved_y);
  }
  const int count{cells * cells};
  if (i >= count) return;
  const float standing{before.scale[i] * before.mass[static_cast<std::size_t>(step.standstill()) * count + i]};
  prepared[i] = make_float4(before.scale[i], still_occupied(step, before.occupancy[i]),
                            gained_by_moving(step, 1.0f, standing), disturbed_standing(step, 1.0f, standing));
}

__global__ void __launch_bounds__(warps_max* warp, 4)
    filter_tay_cells(const FilterMotion* motion, Lattice lattice, const float* likelihoods, const float4* prepared,
                     View<const float, Device> observed, StateBefore before, StateAfter after, LayerPointers layers) {
  __shared__ StripSums shared;
  const int cells{observed.width};
  const int x{static_cast<int>(blockIdx.x) * strip_columns + static_cast<int>(threadIdx.x)};
  const int y{static_cast<int>(blockIdx.y) * strip_rows};
  const bool is_written{threadIdx.x < strip_columns && x < cells};
  const int moved_x{motion->moved_x};
  const int moved_y{motion->moved_y};
  const auto is_known_before = [&](int row) {
    return x + moved_x >= 0 && x + moved_x < cells && row + moved_y >= 0 && row + moved_y < cells;
  };
  Strip strip{motion->step, before.mass, prepared, cells, x, y, is_written, {}};
  for (int r{0}; r < strip_rows; ++r) {
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
    const int i{(y + r) * cells + x};
    const int lane{static_cast<int>(threadIdx.x)};
    const VelocitySums sums{total_of(shared, r, lane)};
    const float scale{1 / shared.all[r][lane]};
    const float age_s{is_known_before(y + r) ? before.age_s[i + moved_y * cells + moved_x] : INFINITY};
    after.scale[i] = scale;
    after.occupancy[i] = layers.occupancy[i] = scale * sums.mass;
    after.age_s[i] = layers.age_s[i] = is_known(observed(x, y + r)) ? 0.0f : age_s + motion->dt_s;
    write_velocity(estimate_of(sums), i, layers);
    layers.moving[i] = moving_share(scale * sums.mass, scale * shared.standing[r][lane]);
  }
}

__global__ void request_reset(const FilterMotion* motion, FilterModel model, JointPointers state, int count,
                              int blocks) {
  const int i{static_cast<int>(blockIdx.x * prepare_threads + threadIdx.x)};
  if (i <= blocks) state.slots[i] = i < blocks ? -1 : 0;
  if (i >= count) return;
  const FilterStep& step{motion->step};
  for (int k{0}; k < step.velocities() && model == FilterModel::tay2008; ++k) {
    state.mass[static_cast<std::size_t>(k) * count + i] = prior_of(step, k);
  }
  state.scale[i] = 1;
  state.birth_static[i] = state.birth_moving[i] = 0;
  state.standing[i] = 0.5f * step.prior_static;
  state.occupancy[i] = 0.5f;
  state.age_s[i] = INFINITY;
}

StateBefore pointers(const FilterStateOnDevice& state) {
  return {state.mass.data(), state.scale.data(), state.occupancy.data(), state.age_s.data()};
}
StateAfter pointers(FilterStateOnDevice& state) {
  return {state.mass.data(), state.scale.data(), state.occupancy.data(), state.age_s.data()};
}
// As many as share the rows of the lattice evenly.
int warps_for(int side) {
  const int rounds{(side + warps_max - 1) / warps_max};
  return (side + rounds - 1) / rounds;
}

// Speeds of the lattice's columns and rows.
std::vector<double> speeds(const std::vector<Point2>& lattice) {
  std::vector<double> result;
  for (std::size_t i{0}; i * i < lattice.size(); ++i) result.push_back(lattice[i].x);
  return result;
}

void filter_tay(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
                const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers) {
  const int cells{observed.width};
  const int most{cells * cells > filter.side * filter.side ? cells * cells : filter.side * filter.side};
  launch(cuda, prepare_tay, blocks_for(most, prepare_threads), prepare_threads, 0, motion, filter.speed_mps.data(),
         pointers(before), cells, filter.from.data(), filter.prepared.data());
  launch(cuda, filter_tay_cells, dim3{blocks_for(cells, strip_columns), blocks_for(cells, strip_rows)},
         dim3{warp, static_cast<unsigned>(warps_for(filter.side))}, 0, motion,
         Lattice{filter.rounded_speed_mps.data(), filter.from.data()}, filter.likelihood.data(), filter.prepared.data(),
         observed, pointers(before), pointers(after), pointers(layers));
}

std::size_t masses_of(const FilterConfig& config, int cells) {
  const std::size_t velocities{velocity_lattice(config).size()};
  const std::size_t together{config.model == FilterModel::joint
                                 ? static_cast<std::size_t>(block_capacity(cells, config)) * block_cells
                                 : static_cast<std::size_t>(cells * cells)};
  return velocities * together;
}

}  // namespace

FilterMotion filter_motion(const FilterInput& input, const GridGeometry& before) {
  const Scroll scroll{scroll_between(before, input.geometry)};
  return {step_of(input), static_cast<float>(input.dt_s), input.dt_s / input.geometry.cell_size_m, scroll.x, scroll.y};
}

FilterStateOnDevice::FilterStateOnDevice(Cuda& cuda, const FilterConfig& config, int cells)
    : mass{masses_of(config, cells)},
      slots{static_cast<std::size_t>(BlockLayout{cells}.count()) + 2},
      scale{cells, cells},
      birth_static{cells, cells},
      birth_moving{cells, cells},
      occupancy{cells, cells},
      standing{cells, cells},
      age_s{cells, cells} {
  // cells of blocks without masses never get a scale or birth, but are read and saved
  for_each_array([&](auto* data, std::size_t size) { clear(cuda, data, size); });
}

FilterOnDevice::FilterOnDevice(Cuda& cuda, const FilterConfig& config, const FilterTables& tables, int cells)
    : model{config.model},
      side{static_cast<int>(speeds(tables.lattice).size())},
      likelihood{tables.likelihood.size()},
      speed_mps{static_cast<std::size_t>(side)},
      rounded_speed_mps{static_cast<std::size_t>(side)},
      from{tables.lattice.size()},
      prepared{cells, cells},
      capacity{block_capacity(cells, config)},
      each_moving{tables.each_moving},
      moving_from{tables.moving_from},
      even{cells, cells},
      spread{cells, cells},
      moving{static_cast<std::size_t>(BlockLayout{cells}.count())},
      starts{static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells)} {
  const std::vector<double> of_lattice{speeds(tables.lattice)};
  const std::vector<float> rounded(of_lattice.begin(), of_lattice.end());
  upload(cuda, of_lattice.data(), of_lattice.size(), speed_mps.data());
  upload(cuda, rounded.data(), rounded.size(), rounded_speed_mps.data());
  upload(cuda, tables.likelihood.data(), tables.likelihood.size(), likelihood.data());
  cuda.synchronize();  // the tables are the caller's
}

void reset(Cuda& cuda, const FilterOnDevice& filter, const FilterMotion* motion, FilterStateOnDevice& state) {
  const int count{static_cast<int>(state.scale.size())};
  const int blocks{static_cast<int>(state.slots.size()) - 2};
  launch(cuda, request_reset, blocks_for(count + 1, prepare_threads), prepare_threads, 0, motion, filter.model,
         joint_pointers(state), count, blocks);
}

void filter(Cuda& cuda, FilterOnDevice& filter, const FilterMotion* motion, View<const float, Device> observed,
            const FilterStateOnDevice& before, FilterStateOnDevice& after, LayersOnDevice& layers) {
  const bool is_joint{filter.model == FilterModel::joint};
  (is_joint ? filter_joint : filter_tay)(cuda, filter, motion, observed, before, after, layers);
}

}  // namespace stereogrid
