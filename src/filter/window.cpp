// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "clamped_to_int.hpp"
#include "filter/filter.hpp"

namespace stereogrid {
namespace {

/// Parts of `weigh_velocities`: more than threads, so that none waits long for another one's.
constexpr int parts_of_a_thread{4};

constexpr float never{std::numeric_limits<float>::infinity()};

float smooth_value(const Image<float>& cells, double x, double y) {
  const auto at = [&](int ix, int iy) { return cells(ix, iy); };
  return interpolated(at, cells.width(), cells.height(), x, y);
}

}  // namespace

std::vector<double> velocity_axis(const FilterConfig& config) {
  std::vector<double> axis{0};
  for (const double speed_mps : config.speeds_mps) {
    axis.insert(axis.begin(), -speed_mps);
    axis.push_back(speed_mps);
  }
  return axis;
}

std::vector<Point2> velocity_lattice(const FilterConfig& config) {
  const std::vector<double> axis{velocity_axis(config)};
  std::vector<Point2> lattice;
  for (const double y_mps : axis) {
    for (const double x_mps : axis) lattice.push_back({x_mps, y_mps});
  }
  return lattice;
}

Window::Window(const GridGeometry& grid)
    : cell_size_m_{grid.cell_size_m},
      ahead_m_{grid.x_min_m + grid.nx * grid.cell_size_m / 2},
      aside_m_{grid.y_min_m + grid.ny * grid.cell_size_m / 2},
      cells_{static_cast<int>(std::ceil(std::hypot(grid.nx, grid.ny))) + 4} {}

GridGeometry Window::at(const Pose2& world_from_vehicle) const {
  const Point2 centre{world_from_vehicle * Point2{ahead_m_, aside_m_}};
  const int half{cells_ / 2};
  const double first_x{std::floor(centre.x / cell_size_m_) - half};
  const double first_y{std::floor(centre.y / cell_size_m_) - half};
  return {first_x * cell_size_m_, first_y * cell_size_m_, cell_size_m_, cells_, cells_};
}

Scroll scroll_between(const GridGeometry& before, const GridGeometry& now) {
  return {clamped_to_int(std::round((now.x_min_m - before.x_min_m) / now.cell_size_m)),
          clamped_to_int(std::round((now.y_min_m - before.y_min_m) / now.cell_size_m))};
}

FilterTables::FilterTables(const FilterConfig& config) : lattice{velocity_lattice(config)} {
  for (const double v_mps : velocity_axis(config)) axis_mps.push_back(static_cast<float>(v_mps));
  for (int i{0}; i <= likelihood_steps; ++i) {
    const double p{static_cast<double>(i) / likelihood_steps};
    likelihood.push_back(static_cast<float>(std::pow(p, config.likelihood_exponent)));
  }
  moving_from = config.scene_flow ? moving_told : moving_found;
  each_moving = lattice.size() > 1 ? 1 / static_cast<float>(lattice.size() - 1) : 0.0f;
}

WeighingSpace::WeighingSpace(int cells, const FilterTables& tables, int threads)
    : masses(static_cast<std::size_t>(threads * parts_of_a_thread),
             std::vector<float>(tables.lattice.size() * block_columns)),
      starts(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells)) {
  const BlockLayout layout{cells};
  ranges.reserve(static_cast<std::size_t>(layout.across) * static_cast<std::size_t>(cells));
}

GridLayers grid_layers(const GridGeometry& geometry) {
  const Image<float> zero{geometry.nx, geometry.ny};
  return {geometry, zero, zero, zero, zero, zero, zero, zero, zero};
}

FilterSpace::FilterSpace(int cells, std::size_t velocities, FilterModel model)
    : from(velocities), gained{cells, cells}, standing{cells, cells} {
  if (model == FilterModel::joint) {
    even = spread = Image<float>{cells, cells};
    moving.resize(static_cast<std::size_t>(BlockLayout{cells}.count()));
  } else {
    still_occupied = Image<float>{cells, cells};
  }
}

int block_capacity(int cells, const FilterConfig& config) {
  if (config.model != FilterModel::joint) return 0;
  const int blocks{BlockLayout{cells}.count()};
  return config.static_prior > 0 ? std::min(moving_blocks_max, blocks) : blocks;
}

FilterState::FilterState(int cells, const FilterConfig& config)
    : blocks{cells, velocity_lattice(config).size(), block_capacity(cells, config)},
      space{cells, velocity_lattice(config).size(), config.model},
      occupancy{cells, cells, 0.5f},
      age_s{cells, cells, never} {
  if (config.model == FilterModel::joint) {
    standing = Image<float>{cells, cells};
  } else {
    velocity.assign(velocity_lattice(config).size(), Image<float>{cells, cells});
  }
}

float mass_of(const FilterState& state, std::size_t k, int x, int y) {
  if (!state.velocity.empty()) return state.velocity[k](x, y);
  const std::size_t velocities{state.space.from.size()};
  if (const float* const masses{state.blocks.masses_at(x, y)}; masses != nullptr) return masses[k * block_cells];
  const float standing{state.standing(x, y)};
  if (k == velocities / 2) return standing;
  return even_mass(1 / static_cast<float>(velocities - 1), state.occupancy(x, y), standing);
}

namespace {

// Where the disparity of a point has changed by so much the errors of matching are others.
constexpr double new_view_px{0.5};

// How much more seldom a standing thing starts than a moving one changes its velocity.
constexpr double starting_share{0.1};

// The time that filter.velocity_noise speaks of.
constexpr double noise_interval_s{0.1};

// What changes within dt_s of what changes by `share` within that time.
double share_within(double share, double dt_s) {
  return 1 - std::pow(1 - share, dt_s / noise_interval_s);
}

void set_noise(const FilterConfig& config, double dt_s, int velocities, FilterStep& step) {
  const double others{velocities - 1.0};
  const double noise{share_within(config.velocity_noise, dt_s)};
  step.kept_moving = static_cast<float>(1 - noise);
  if (config.static_prior == 0) {
    step.spread = step.start = step.stop = static_cast<float>(noise / velocities);
    step.kept_standing = static_cast<float>(1 - noise + noise / velocities);
    step.prior_static = step.prior_moving = static_cast<float>(1.0 / velocities);
  } else {
    const double starting{share_within(config.velocity_noise * starting_share, dt_s)};
    step.spread = static_cast<float>(noise / others);
    step.start = static_cast<float>(starting / others);
    step.kept_standing = static_cast<float>(1 - starting);
    step.prior_static = static_cast<float>(config.static_prior);
    step.prior_moving = static_cast<float>((1 - config.static_prior) / others);
  }
  step.appearing_static = std::min(step.prior_static, static_cast<float>(config.appearing_static));
  step.appearing_moving = static_cast<float>((1 - static_cast<double>(step.appearing_static)) / others);
}

}  // namespace

FilterStep step_of(const FilterInput& input) {
  const FilterConfig& config{input.config};
  FilterStep step{};
  step.side = static_cast<int>(input.tables.axis_mps.size());
  const auto forgetting = [&](double time_s) { return static_cast<float>((1 - std::exp(-input.dt_s / time_s)) / 2); };
  step.forgetting = forgetting(config.forgetting_s);
  step.forgetting_in_view = forgetting(config.forgetting_in_view_s);
  step.border_occupancy = config.model == FilterModel::joint ? static_cast<float>(config.border_occupancy) : 0.5f;
  const GridGeometry& grid{input.geometry};
  const CameraView& view{input.view};
  step.camera_x = static_cast<float>((view.camera.x_m - grid.x_min_m) / grid.cell_size_m - 0.5);
  step.camera_y = static_cast<float>((view.camera.y_m - grid.y_min_m) / grid.cell_size_m - 0.5);
  step.ahead_x = static_cast<float>(std::cos(view.camera.yaw_rad));
  step.ahead_y = static_cast<float>(std::sin(view.camera.yaw_rad));
  step.view_left = static_cast<float>(view.left);
  step.view_right = static_cast<float>(view.right);
  step.new_view_squares = static_cast<float>(view.parallax_px_m2 / new_view_px / (grid.cell_size_m * grid.cell_size_m));
  step.kept_standing = step.kept_moving = step.prior_static = step.appearing_static = 1;
  step.moving_velocities = static_cast<float>(step.velocities() - 1);
  step.each_moving = input.tables.each_moving;
  step.moving_from = input.tables.moving_from;
  if (step.side == 1) return step;
  step.reach = clamped_to_int(std::ceil(input.tables.lattice.back().x * input.dt_s / grid.cell_size_m));
  set_noise(config, input.dt_s, step.velocities(), step);
  double squares{0};
  for (const Point2 v : input.tables.lattice) squares += v.x * v.x;
  step.lattice_squares = static_cast<float>(squares);
  return step;
}

void reset(FilterState& state, const FilterConfig& config, const GridGeometry& geometry) {
  const FilterTables tables{config};
  const FilterStep step{step_of({config, tables, geometry, 0})};
  state.geometry = geometry;
  for (std::size_t k{0}; k < state.velocity.size(); ++k) {
    state.velocity[k].fill(prior_of(step, static_cast<int>(k)));
  }
  state.standing.fill(0.5f * step.prior_static);
  state.blocks.clear();
  state.occupancy.fill(0.5f);
  state.age_s.fill(never);
}

namespace {

// From the window to vehicle axes.
class Resampler {
 public:
  Resampler(const Pose2& world_from_vehicle, FrameResult& result)
      : world_{result.world},
        to_{result.vehicle},
        c_{static_cast<float>(std::cos(world_from_vehicle.yaw_rad))},
        s_{static_cast<float>(std::sin(world_from_vehicle.yaw_rad))} {}

  // Vehicle cell (ix, iy) from the place (x, y) of its centre, in cells of the window.
  void fill(int ix, int iy, double x, double y) const {
    if (!(x >= 0 && x < world_.geometry.nx && y >= 0 && y < world_.geometry.ny)) return fill_outside(ix, iy);
    to_.occupancy(ix, iy) = smooth_value(world_.occupancy, x - 0.5, y - 0.5);
    to_.moving(ix, iy) = smooth_value(world_.moving, x - 0.5, y - 0.5);
    fill_nearest(ix, iy, static_cast<int>(x), static_cast<int>(y));
  }

 private:
  void fill_outside(int ix, int iy) const {
    to_.occupancy(ix, iy) = 0.5f;
    to_.age_s(ix, iy) = never;
    to_.moving(ix, iy) = to_.velocity_x(ix, iy) = to_.velocity_y(ix, iy) = 0;
    to_.velocity_xx(ix, iy) = to_.velocity_xy(ix, iy) = to_.velocity_yy(ix, iy) = 0;
  }

  void fill_nearest(int ix, int iy, int x, int y) const {
    to_.age_s(ix, iy) = world_.age_s(x, y);
    const VelocityEstimate v{turned({world_.velocity_x(x, y), world_.velocity_y(x, y), world_.velocity_xx(x, y),
                                     world_.velocity_xy(x, y), world_.velocity_yy(x, y)},
                                    c_, s_)};
    to_.velocity_x(ix, iy) = v.x;
    to_.velocity_y(ix, iy) = v.y;
    to_.velocity_xx(ix, iy) = v.xx;
    to_.velocity_xy(ix, iy) = v.xy;
    to_.velocity_yy(ix, iy) = v.yy;
  }

  const GridLayers& world_;
  GridLayers& to_;
  float c_;
  float s_;
};

}  // namespace

namespace {

// Calls work(ix, iy, x, y) for each cell of some rows of the vehicle's grid and the place of its centre, in cells of
// the window.
template <class Work>
void for_vehicle_cells(const GridGeometry& window, const Pose2& world_from_vehicle, const GridGeometry& grid,
                       int first_row, int end_row, const Work& work) {
  for (int iy{first_row}; iy < end_row; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const Point2 at{world_from_vehicle * grid.centre(ix, iy)};
      work(ix, iy, (at.x - window.x_min_m) / window.cell_size_m, (at.y - window.y_min_m) / window.cell_size_m);
    }
  }
}

}  // namespace

void resample_rows(const Pose2& world_from_vehicle, int begin, int end, FrameResult& result) {
  const Resampler resampler{world_from_vehicle, result};
  for_vehicle_cells(result.world.geometry, world_from_vehicle, result.vehicle.geometry, begin, end,
                    [&](int ix, int iy, double x, double y) { resampler.fill(ix, iy, x, y); });
}

void resample_occupancy(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
                        Image<float>& occupancy) {
  const GridGeometry& window{world.geometry};
  for_vehicle_cells(window, world_from_vehicle, vehicle_grid, 0, vehicle_grid.ny,
                    [&](int ix, int iy, double x, double y) {
                      const bool is_inside{x >= 0 && x < window.nx && y >= 0 && y < window.ny};
                      occupancy(ix, iy) = is_inside ? smooth_value(world.occupancy, x - 0.5, y - 0.5) : 0.5f;
                    });
}

}  // namespace stereogrid
