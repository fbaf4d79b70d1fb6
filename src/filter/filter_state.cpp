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

/// Occupancy assumed outside the window; joint form.
constexpr float border_occupancy{0.2f};
/// Prior of standstill for mass that appears where the frame before saw free ground; at most static_prior.
constexpr float appearing_static{0.4f};

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

FilterTables::FilterTables(const FilterConfig& config) : lattice{velocity_lattice(config)} {
  for (const double v_mps : velocity_axis(config)) axis_mps.push_back(static_cast<float>(v_mps));
  for (int i{0}; i <= likelihood_steps; ++i) {
    const double p{static_cast<double>(i) / likelihood_steps};
    likelihood.push_back(static_cast<float>(std::pow(p, config.likelihood_exponent)));
  }
  moving_from = config.scene_flow ? moving_from_flow : moving_found;
  each_moving = lattice.size() > 1 ? 1 / static_cast<float>(lattice.size() - 1) : 0.0f;
}

WeighingWorkspace::WeighingWorkspace(int cells, const FilterTables& tables, int threads)
    : masses(static_cast<std::size_t>(threads * parts_of_a_thread),
             std::vector<float>((tables.lattice.size() + 2 * tables.axis_mps.size()) * block_columns)),
      starts(static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells)) {
  const BlockLayout layout{cells};
  ranges.reserve(static_cast<std::size_t>(layout.across) * static_cast<std::size_t>(cells));
}

GridLayers grid_layers(const GridGeometry& geometry) {
  const Image<float> zero{geometry.nx, geometry.ny};
  return {geometry, zero, zero, zero, zero, zero, zero, zero, zero};
}

FilterWorkspace::FilterWorkspace(int cells, std::size_t velocities, FilterModel model)
    : from(velocities), gained{cells, cells}, standing{cells, cells}, active{model == FilterModel::joint ? cells : 0} {
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
    kinds.resize(static_cast<std::size_t>(blocks.layout().count()));
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

// Depth per pixel of disparity, in cells, beyond which new mass has the default share of motion.
constexpr double cells_of_pixel_max{30};

// Depth per pixel of disparity, in cells, up to which a cell in view keeps its state for filter.decay_time_in_view_s;
// beyond, for a time in inverse proportion. A standard deviation of disparity, 0.2 px, is one cell deep there.
constexpr double cells_of_pixel_sharp{5};

// Distance of the masses' end; scene flow (scene_flow.cpp) detects motion up to 40 m.
constexpr double followed_max_m{45};

// Rate at which static mass starts to move, relative to velocity changes of dynamic mass.
constexpr double starting_share{0.1};

// Interval of filter.velocity_noise.
constexpr double noise_interval_s{0.1};

// Share that changes within dt_s, if `share` changes within that interval.
double share_within(double share, double dt_s) {
  return 1 - std::pow(1 - share, dt_s / noise_interval_s);
}

ViewOfStep view_of_step(const CameraView& view, const GridGeometry& grid) {
  return {static_cast<float>((view.camera.x_m - grid.x_min_m) / grid.cell_size_m - 0.5),
          static_cast<float>((view.camera.y_m - grid.y_min_m) / grid.cell_size_m - 0.5),
          static_cast<float>(std::cos(view.camera.yaw_rad)),
          static_cast<float>(std::sin(view.camera.yaw_rad)),
          static_cast<float>(view.left),
          static_cast<float>(view.right),
          static_cast<float>(view.nearest_m / grid.cell_size_m),
          static_cast<float>(view.baseline_m / grid.cell_size_m)};
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
  step.appearing_static = std::min(step.prior_static, appearing_static);
  step.appearing_moving = static_cast<float>((1 - static_cast<double>(step.appearing_static)) / others);
}

}  // namespace

FilterStep step_of(const FilterInput& input) {
  const FilterConfig& config{input.config};
  FilterStep step{};
  step.side = static_cast<int>(input.tables.axis_mps.size());
  const auto decay = [&](double time_s) { return static_cast<float>((1 - std::exp(-input.dt_s / time_s)) / 2); };
  step.decay = decay(config.decay_time_s);
  step.decay_in_view = decay(config.decay_time_in_view_s);
  step.border_occupancy = config.model == FilterModel::joint ? border_occupancy : 0.5f;
  const GridGeometry& grid{input.geometry};
  const CameraView& view{input.view};
  step.views[0] = view_of_step(view, grid);
  step.other_views = static_cast<int>(input.other_views.size());
  for (std::size_t i{0}; i < input.other_views.size(); ++i)
    step.views[i + 1] = view_of_step(input.other_views[i], grid);
  const double square_m2{grid.cell_size_m * grid.cell_size_m};
  step.new_view_squares = static_cast<float>(view.parallax_px_m2 / CameraView::new_view_px / square_m2);
  step.appearing_squares = static_cast<float>(view.focal_baseline_pxm * cells_of_pixel_max / grid.cell_size_m);
  step.sharp_squares = static_cast<float>(view.focal_baseline_pxm * cells_of_pixel_sharp / grid.cell_size_m);
  const bool has_flow{config.scene_flow && view.left >= 0};
  const double followed_m{has_flow ? followed_max_m : std::numeric_limits<double>::infinity()};
  step.moving_squares = static_cast<float>(followed_m * followed_m / square_m2);
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
  std::fill(state.kinds.begin(), state.kinds.end(), BlockKind::unseen);
}

}  // namespace stereogrid
