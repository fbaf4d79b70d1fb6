// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "filter/resampling/resample_model.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// From the window's layers to the vehicle's.
struct Resampling {
  GridInVehicle cells;  ///< the vehicle's grid in the world
  CellPlaces places;    ///< its cells in the window
  const GridLayers& world;
  GridLayers& vehicle;
};

/// `resample` for the cells begin … end − 1 of row iy.
void resample_cells(const Resampling& resampling, int begin, int end, int iy);
/// The same of cells around which the window has even blocks only. `were_even`: the vehicle's cells are so already.
void resample_even_cells(const Resampling& resampling, int begin, int end, int iy, bool were_even);

}  // namespace stereogrid
