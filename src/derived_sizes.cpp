// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "derived_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

namespace stereogrid {
namespace {

constexpr int cells_max{4000};  // along a side
constexpr double velocities_max{1000};
constexpr double lattice_bytes_max{64.0 * (1 << 30)};

// Velocities of the filter's lattice.
double lattice_size(const FilterConfig& config) {
  const double side{2 * static_cast<double>(config.speeds_mps.size()) + 1};
  return side * side;
}

// Bytes of a number for each cell of the window and each velocity, in two states.
double lattice_bytes(const Config& config) {
  const double side{std::hypot(config.grid.length_m, config.grid.width_m) / config.grid.cell_size_m};
  return 2 * sizeof(float) * lattice_size(config.filter) * side * side;
}

// "a is 1, b is 5"
std::string values_of(const Config& config, std::initializer_list<std::string_view> keys) {
  std::string text;
  for (const std::string_view key : keys) {
    text += (text.empty() ? "" : ", ") + std::string{key} + " is " + get(config, key);
  }
  return text;
}

}  // namespace

void add_problems_of_sizes(const Config& config, std::vector<std::string>& found) {
  const auto has_problem = [own = found](std::string_view key) {
    return std::ranges::any_of(own, [key](const std::string& problem) { return problem.starts_with(key); });
  };
  const auto require = [&](bool is_fine, std::initializer_list<std::string_view> keys, const std::string& problem) {
    if (!is_fine && std::ranges::none_of(keys, has_problem)) found.push_back(values_of(config, keys) + ": " + problem);
  };
  const auto require_cells = [&](std::string_view key, double side_m) {
    const double cells{std::round(side_m / config.grid.cell_size_m)};
    require(cells >= 1 && cells <= cells_max, {key, "grid.cell_size_m"},
            (cells < 1 ? "no cell" : "more than " + std::to_string(cells_max) + " cells") +
                " along that side (allowed 1 … " + std::to_string(cells_max) + "). Take " +
                (cells < 1 ? "smaller cells or a larger grid." : "larger cells or a smaller grid."));
  };
  require_cells("grid.length_m", config.grid.length_m);
  require_cells("grid.width_m", config.grid.width_m);
  require(config.u_disparity.obstacle_min_height_m < config.u_disparity.obstacle_height_m,
          {"u_disparity.obstacle_min_height_m", "u_disparity.obstacle_height_m"},
          "no height is left for obstacles. Take a minimum height below the other.");
  require(config.vehicle.step_max_m < config.vehicle.height_m, {"vehicle.step_max_m", "vehicle.height_m"},
          "no height is left for obstacles. Take a step below the vehicle's height.");
  if (lattice_size(config.filter) > velocities_max) {
    found.emplace_back("filter.speeds_mps: more than 1000 velocities. Take fewer speeds.");
    return;
  }
  require(lattice_bytes(config) <= lattice_bytes_max,
          {"grid.length_m", "grid.width_m", "grid.cell_size_m", "filter.speeds_mps"},
          "the window's cells times the velocities take more than 64 GiB. Take larger cells, a smaller grid or fewer "
          "speeds.");
}

}  // namespace stereogrid
