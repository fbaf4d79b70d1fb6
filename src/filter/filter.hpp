// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "filter/model.hpp"
#include "filter/particles.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// Velocities of the filter's lattice, world axes, y-major; the middle one is standstill.
std::vector<Point2> velocity_lattice(const FilterConfig& config);

/// World-aligned window that covers a vehicle-frame grid in every heading. Its origin is a whole number of cells.
class Window {
 public:
  explicit Window(const GridGeometry& vehicle_grid);

  /// Number of cells along a side.
  [[nodiscard]] int cells() const { return cells_; }
  /// Geometry of the window for a pose of the car.
  [[nodiscard]] GridGeometry at(const Pose2& world_from_vehicle) const;

 private:
  double cell_size_m_;
  double ahead_m_;
  double aside_m_;
  int cells_;
};

/// What the filter remembers: per cell, P(occupied), and mass[k] = P(occupied, v_k) (joint) or P(v_k) (tay2008), or
/// particles.
struct FilterState {
  FilterState(int cells, const FilterConfig& config);

  GridGeometry geometry;               ///< of the last step; nx = 0: no step yet
  std::vector<Image<float>> velocity;  ///< [k]; none with particles
  Particles particles;                 ///< none with the other models
  Image<float> occupancy;
  Image<float> age_s;
};

/// What the filter knows about one step besides the observation.
struct FilterInput {
  const FilterConfig& config;
  const std::vector<Point2>& lattice;
  GridGeometry geometry;  ///< of the window now
  double dt_s;            ///< since the last step
};

/// One step of the Bayesian Occupancy Filter: `before` moved on by dt and into the window's new place, then updated
/// with the observed grid (P(T_X) at the window's cells, 0.5 = nothing seen), into `after`. `layers` gets occupancy,
/// velocity (mean given occupied) and age. method §2.3 (tay2008), §2.6 (joint) and §5.8 (particles).
void filter(Cpu& cpu, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers);
void filter(Reference& reference, const FilterInput& input, View<const float> observed, const FilterState& before,
            FilterState& after, GridLayers& layers);

/// All cells unknown, at the window's place.
void reset(FilterState& state, const FilterConfig& config, const GridGeometry& geometry);

FilterStep step_of(const FilterInput& input);
Likelihood likelihood_of(const FilterConfig& config, float observed);

/// How much more seldom a standing thing starts than a moving one changes its velocity.
constexpr double starting_share{0.1};

/// Cells that differ this much from 0.5 have been observed.
constexpr float observed_difference{0.05f};

/// The window's layers as the car sees them: occupancy interpolated between cells, velocity (turned into vehicle axes)
/// and age of the nearest cell; 0.5, 0 and inf outside the window.
void resample(const GridLayers& world, const Pose2& world_from_vehicle, const GridGeometry& vehicle_grid,
              Image<float>& occupancy, Image<float>& velocity_x, Image<float>& velocity_y, Image<float>& age_s);

}  // namespace stereogrid
