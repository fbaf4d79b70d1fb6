// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "filter/cuda.hpp"

#include <cmath>
#include <vector>

#include "stereogrid/error.hpp"

namespace stereogrid {
namespace {

constexpr int warp{32};
constexpr int strip_columns{warp - 1};  // a lane more reads the neighbour of the last one
constexpr int strip_rows{4};
constexpr int warps_max{6};
constexpr int prepare_threads{256};
constexpr int cells_width{32};
constexpr int cells_height{8};
constexpr unsigned whole_warp{0xffffffffu};

// What the host hands to every kernel.
struct StateBefore {
  const float* mass;
  const float* scale;
  const float* born;
  const float* occupancy;
  const float* age_s;
};
struct StateAfter {
  float* mass;
  float* scale;
  float* born;
  float* occupancy;
  float* age_s;
};
struct LayerPointers {
  float* occupancy;
  float* velocity_x;
  float* velocity_y;
  float* age_s;
  float* velocity_xx;
  float* velocity_xy;
  float* velocity_yy;
  float* moving;
};

// --- before: what prediction reads of each cell, and where the masses of each velocity come from ---------------------

// Of the prepared numbers, x is the scale, w the standing mass after the noise, z what each moving velocity gains;
// y is born·prior of a moving velocity (joint), or P(still occupied) (tay2008).
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
  const float standing{before.scale[i] * arrived + before.born[i] * step.prior_static};
  constexpr bool joint{model == FilterModel::joint};
  const float all{joint ? before.occupancy[i] : 1.0f};
  prepared[i] = make_float4(before.scale[i],
                            joint ? before.born[i] * step.prior_moving : still_occupied(step, before.occupancy[i]),
                            gained_by_moving(step, all, standing), disturbed_standing(step, all, standing));
}

// --- the step: a block has a strip of 31 × 4 cells, a warp of it some rows of the lattice ----------------------------

enum Sum { of_mass, of_mass_x, of_mass_xx, of_all, sums };

struct Lattice {
  const float* speed;
  const Antecedents* from;
};

// Shared by the warps of a block.
struct StripSums {
  float of_row[warps_max][sums][strip_rows][warp];  // of the rows of the lattice that are worked on
  float total[6][strip_rows][warp];                 // VelocitySums
  float all[strip_rows][warp];
  float standing[strip_rows][warp];  // mass of standstill; tay2008: that is occupied
};

// The cells of a strip that a lane has: column x, rows y … y + 3.
template <FilterModel model>
struct Strip {
  FilterStep step;
  const float* mass;
  const float4* prepared;
  int cells;
  int x;
  int y;
  bool is_written;            // has cells of its own
  bool is_known[strip_rows];  // they have been in the window before
  Likelihood likelihood[strip_rows];

  static constexpr bool joint{model == FilterModel::joint};

  struct Arrived {
    float all[strip_rows];
    float occupied[strip_rows];  // tay2008
  };

  // What the noise leaves of a velocity's mass: in all, and (tay2008) occupied.
  struct Disturbed {
    float all;
    float occupied;
  };
  __device__ Disturbed outside(float prior) const {
    if (joint) return {step.border_occupancy * prior, 0};
    return {prior, prior * still_occupied(step, 0.5f)};
  }
  __device__ Disturbed inside(bool stands, const float4& of_cell, float arrived) const {
    const float before{of_cell.x * arrived};
    const float moving{disturbed(step, joint ? before + of_cell.y : before, of_cell.z)};
    const float all{stands ? of_cell.w : moving};
    return {all, joint ? 0.0f : all * of_cell.y};
  }

  __device__ int nearest(int index) const { return index < 0 ? 0 : (index < cells ? index : cells - 1); }

  __device__ void gather(int k, const Antecedents& from, float prior, Arrived& arrived) const {
    const int ax{x + from.ix};
    const int ay{y + from.iy};
    const float* plane{mass + static_cast<std::size_t>(k) * (cells * cells)};
    float4 of_cell[strip_rows + 1];
    float before[strip_rows + 1];
    for (int r{0}; r <= strip_rows; ++r) {  // without a branch: all of them are asked for before one is needed
      const int at{nearest(ay + r) * cells + nearest(ax)};
      of_cell[r] = prepared[at];
      before[r] = plane[at];
    }
    Disturbed across[strip_rows + 1];
    for (int r{0}; r <= strip_rows; ++r) {
      const bool is_inside{ax >= 0 && ax < cells && ay + r >= 0 && ay + r < cells};
      const Disturbed here{is_inside ? inside(k == step.standstill(), of_cell[r], before[r]) : outside(prior)};
      across[r].all = between(here.all, __shfl_down_sync(whole_warp, here.all, 1), from.fx);
      if (!joint) across[r].occupied = between(here.occupied, __shfl_down_sync(whole_warp, here.occupied, 1), from.fx);
    }
    for (int r{0}; r < strip_rows; ++r) {
      arrived.all[r] = between(across[r].all, across[r + 1].all, from.fy);
      if (!joint) arrived.occupied[r] = between(across[r].occupied, across[r + 1].occupied, from.fy);
    }
  }

  // The masses of velocity k; those that are written are what tay_update calls l(k), or what has arrived (joint).
  __device__ void update(int k, float prior, Arrived& arrived, float* after) const {
    for (int r{0}; r < strip_rows; ++r) {
      if constexpr (joint) {
        if (!is_known[r]) arrived.all[r] = 0.5f * prior;
      } else {
        const TayUpdate updated_mass{tay_update(arrived.all[r], arrived.occupied[r], likelihood[r])};
        arrived.all[r] = updated_mass.all;
        arrived.occupied[r] = updated_mass.occupied;
      }
      if (is_written && y + r < cells) {
        after[static_cast<std::size_t>(k) * (cells * cells) + (y + r) * cells + x] = arrived.all[r];
      }
    }
  }

  // Row j of the lattice, and its sums.
  __device__ void run_row(const Lattice& lattice, int j, float* after, float (&of_row)[sums][strip_rows][warp],
                          StripSums& strip) const {
    const int lane{static_cast<int>(threadIdx.x)};
    float row[sums][strip_rows]{};
    for (int i{0}; i < step.side; ++i) {
      const int k{j * step.side + i};
      const float prior{prior_of(step, k)};
      const float vx{lattice.speed[i]};
      Arrived arrived;
      gather(k, lattice.from[k], prior, arrived);
      update(k, prior, arrived, after);
      for (int r{0}; r < strip_rows; ++r) {
        const float mass_here{joint ? arrived.all[r] : arrived.occupied[r]};
        row[of_mass][r] += mass_here;
        row[of_mass_x][r] += vx * mass_here;
        row[of_mass_xx][r] += vx * vx * mass_here;
        if constexpr (!joint) row[of_all][r] += arrived.all[r];
        if (k == step.standstill()) strip.standing[r][lane] = mass_here;
      }
    }
    for (int s{0}; s < sums; ++s) {
      for (int r{0}; r < strip_rows; ++r) of_row[s][r][lane] = row[s][r];
    }
  }
};

__device__ VelocitySums total_of(const StripSums& strip, int r, int lane) {
  return {strip.total[0][r][lane], strip.total[1][r][lane], strip.total[2][r][lane],
          strip.total[3][r][lane], strip.total[4][r][lane], strip.total[5][r][lane]};
}

__device__ void keep_total(const VelocitySums& total, int r, int lane, StripSums& strip) {
  const float values[6]{total.mass, total.x, total.y, total.xx, total.xy, total.yy};
  for (int i{0}; i < 6; ++i) strip.total[i][r][lane] = values[i];
}

// Adds the rows first … first + count − 1 of the lattice, in this order.
__device__ void add_rows(const Lattice& lattice, int first, int count, StripSums& strip) {
  const int lane{static_cast<int>(threadIdx.x)};
  for (int r{static_cast<int>(threadIdx.y)}; r < strip_rows; r += static_cast<int>(blockDim.y)) {
    VelocitySums total{first > 0 ? total_of(strip, r, lane) : VelocitySums{}};
    float all{first > 0 ? strip.all[r][lane] : 0.0f};
    for (int w{0}; w < count; ++w) {
      const auto& row{strip.of_row[w]};
      total.add_row(lattice.speed[first + w], row[of_mass][r][lane], row[of_mass_x][r][lane], row[of_mass_xx][r][lane]);
      all += row[of_all][r][lane];
    }
    keep_total(total, r, lane, strip);
    strip.all[r][lane] = all;
  }
}

// What the filter says about a cell after the step.
struct Cell {
  float scale;
  float born;
  float occupancy;
  float standing;
  VelocitySums sums;
};

template <FilterModel model>
__device__ Cell updated_cell(const FilterStep& step, const StripSums& strip, int r, bool never_seen,
                             Likelihood likelihood) {
  const int lane{static_cast<int>(threadIdx.x)};
  const VelocitySums total{total_of(strip, r, lane)};
  const float standing{strip.standing[r][lane]};
  if constexpr (model == FilterModel::joint) {
    const JointUpdate update{joint_update(step, total.mass, never_seen, likelihood)};
    return {update.scale, update.born, update.occupancy, update.scale * standing + update.born * step.prior_static,
            updated(step, update, total)};
  } else {
    const float scale{1 / strip.all[r][lane]};
    return {scale, 0, scale * total.mass, scale * standing, total};
  }
}

__device__ void write(const Cell& cell, float age_s, int i, const StateAfter& after, const LayerPointers& layers) {
  const VelocityEstimate velocity{estimate_of(cell.sums)};
  after.scale[i] = cell.scale;
  after.born[i] = cell.born;
  after.occupancy[i] = layers.occupancy[i] = cell.occupancy;
  after.age_s[i] = layers.age_s[i] = age_s;
  layers.velocity_x[i] = velocity.x;
  layers.velocity_y[i] = velocity.y;
  layers.velocity_xx[i] = velocity.xx;
  layers.velocity_xy[i] = velocity.xy;
  layers.velocity_yy[i] = velocity.yy;
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
    const bool is_seen{fabsf(seen - 0.5f) > observed_difference};
    write(updated_cell<model>(strip.step, shared, r, age_s == INFINITY, likelihood_of(likelihoods, seen)),
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
  state.born[i] = 0;
  state.occupancy[i] = 0.5f;
  state.age_s[i] = INFINITY;
}

// --- into the vehicle's grid: a thread per cell ----------------------------------------------------------------------

__global__ void resample_cells(LayerPointers world, const GridGeometry* window, const GridInVehicle* vehicle_in_world,
                               View<float, Device> occupancy, LayerPointers out) {
  const int ix{static_cast<int>(blockIdx.x * cells_width + threadIdx.x)};
  const int iy{static_cast<int>(blockIdx.y * cells_height + threadIdx.y)};
  if (ix >= occupancy.width || iy >= occupancy.height) return;
  const int to{iy * occupancy.width + ix};
  const Point2 at{vehicle_in_world->centre(ix, iy)};
  const double x{(at.x - window->x_min_m) / window->cell_size_m};
  const double y{(at.y - window->y_min_m) / window->cell_size_m};
  const int nx{window->nx};
  const int ny{window->ny};
  const bool is_inside{x >= 0 && x < nx && y >= 0 && y < ny};
  const auto smooth = [&](const float* layer) {
    const auto value = [&](int cx, int cy) { return layer[cy * nx + cx]; };
    return interpolated(value, nx, ny, x - 0.5, y - 0.5);
  };
  VelocityEstimate velocity{};
  const int from{is_inside ? static_cast<int>(y) * nx + static_cast<int>(x) : 0};
  if (is_inside) {
    velocity = turned({world.velocity_x[from], world.velocity_y[from], world.velocity_xx[from], world.velocity_xy[from],
                       world.velocity_yy[from]},
                      static_cast<float>(vehicle_in_world->cos_yaw), static_cast<float>(vehicle_in_world->sin_yaw));
  }
  out.occupancy[to] = is_inside ? smooth(world.occupancy) : 0.5f;
  out.moving[to] = is_inside ? smooth(world.moving) : 0.0f;
  out.age_s[to] = is_inside ? world.age_s[from] : INFINITY;
  out.velocity_x[to] = velocity.x;
  out.velocity_y[to] = velocity.y;
  out.velocity_xx[to] = velocity.xx;
  out.velocity_xy[to] = velocity.xy;
  out.velocity_yy[to] = velocity.yy;
}

StateBefore pointers(const FilterStateOnDevice& state) {
  return {state.mass.data(), state.scale.data(), state.born.data(), state.occupancy.data(), state.age_s.data()};
}
StateAfter pointers(FilterStateOnDevice& state) {
  return {state.mass.data(), state.scale.data(), state.born.data(), state.occupancy.data(), state.age_s.data()};
}
LayerPointers pointers(const LayersOnDevice& layers) {
  const auto of = [](const DeviceImage<float>& layer) { return const_cast<float*>(layer.data()); };
  return {of(layers.occupancy),   of(layers.velocity_x),  of(layers.velocity_y),  of(layers.age_s),
          of(layers.velocity_xx), of(layers.velocity_xy), of(layers.velocity_yy), of(layers.moving)};
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
      born{cells, cells},
      occupancy{cells, cells},
      age_s{cells, cells} {}

LayersOnDevice::LayersOnDevice(int width, int height)
    : occupancy{width, height},
      velocity_x{width, height},
      velocity_y{width, height},
      age_s{width, height},
      velocity_xx{width, height},
      velocity_xy{width, height},
      velocity_yy{width, height},
      moving{width, height} {}

FilterOnDevice::FilterOnDevice(Cuda& cuda, const FilterConfig& config, const FilterTables& tables, int cells)
    : model{config.model},
      side{static_cast<int>(speeds(tables.lattice).size())},
      likelihood{tables.likelihood.size()},
      speed_mps{static_cast<std::size_t>(side)},
      rounded_speed_mps{static_cast<std::size_t>(side)},
      from{tables.lattice.size()},
      prepared{cells, cells} {
  if (model == FilterModel::particles) {
    throw ConfigError{"filter.model: particles are not on this back end. Take joint or tay2008, or --device cpu."};
  }
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

void resample(Cuda& cuda, const LayersOnDevice& world, const GridGeometry* window,
              const GridInVehicle* vehicle_in_world, LayersOnDevice& vehicle) {
  const int nx{vehicle.occupancy.width()};
  const int ny{vehicle.occupancy.height()};
  launch(cuda, resample_cells, dim3{blocks_for(nx, cells_width), blocks_for(ny, cells_height)},
         dim3{cells_width, cells_height}, 0, pointers(world), window, vehicle_in_world, vehicle.occupancy.view(),
         pointers(vehicle));
}

}  // namespace stereogrid
