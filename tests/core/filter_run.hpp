// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "filter/filter.hpp"

namespace stereogrid::test {

/// Cell 0.2 m, 0.1 s a step: 2 m/s is a cell a step. 5 × 5 velocities, K = 25, eps = 0.01.
inline FilterConfig method_config(FilterModel model) {
  FilterConfig config;
  config.model = model;
  config.scene_flow = false;
  config.speeds_mps = {2, 4};
  config.decay_time_s = 4.95;
  config.velocity_noise = 0.01;
  config.likelihood_exponent = 1;
  config.static_prior = 0.5;
  return config;
}

/// The filter with its two states, step by step.
template <class BackEndType>
class FilterRun {
 public:
  FilterRun(BackEndType& back_end, const FilterConfig& parameters, const GridGeometry& geometry)
      : back_end_{back_end}, config{parameters}, tables{config}, now{geometry.nx, config}, before{now} {
    layers = grid_layers(geometry);
    reset(now, config, geometry);
  }

  void step(const Image<float>& observed, double dt_s = 0.1) { step(observed, dt_s, now.geometry); }

  void step(const Image<float>& observed, double dt_s, const GridGeometry& geometry) {
    std::swap(now, before);
    filter(back_end_, {config, tables, geometry, dt_s}, observed.view(), before, now, layers);
  }

 private:
  BackEndType& back_end_;

 public:
  FilterConfig config;
  FilterTables tables;
  FilterState now;
  FilterState before;
  GridLayers layers;
};

inline Image<float> masses_of(const FilterState& state, std::size_t k) {
  const int cells{state.occupancy.width()};
  Image<float> masses{cells, cells};
  for (const auto [x, y] : raster(cells, cells)) masses(x, y) = mass_of(state, k, x, y);
  return masses;
}

/// A free world of square `cells` with an object of nx × ny cells from (x, y).
inline Image<float> scene(int cells, int x, int y, int nx, int ny, float object = 0.98f, float free = 0.02f) {
  Image<float> observed{cells, cells, free};
  for (const auto [ix, iy] : raster(x, x + nx, y, y + ny)) observed(ix, iy) = object;
  return observed;
}

/// Mean of a layer over nx × ny cells from (x, y).
inline double mean_over(const Image<float>& layer, int x, int y, int nx, int ny) {
  double sum{0};
  for (const auto [ix, iy] : raster(x, x + nx, y, y + ny)) sum += layer(ix, iy);
  return sum / (nx * ny);
}

}  // namespace stereogrid::test
