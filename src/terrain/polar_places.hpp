// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "geometry/grid_in_vehicle.hpp"

namespace stereogrid {

/// Cells of a grid's row in the terrain's polar grid.
struct PolarPlaces {
  static constexpr int size{32};

  std::array<float, size> x;    ///< distance ahead, m
  std::array<int, size> ring;   ///< for Rings::at_place
  std::array<int, size> first;  ///< sectors first … last; none, or not ahead: first > last
  std::array<int, size> last;
};

/// Geometry that all cells of a grid have in common.
struct PolarGeometry {
  float focal_px;
  float focal_baseline_pxm;
  float cx_px;     ///< counted from the first pixel's left border
  float width_px;  ///< width of the image
  int last_sector;
  float half_m;       ///< half a cell
  float ring_places;  ///< Rings::places
  float ring_places_per_px;
};

/// Cells ix, ix + step … of row iy.
void find_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy, PolarPlaces& places);

}  // namespace stereogrid
