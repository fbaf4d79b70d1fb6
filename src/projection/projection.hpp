// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "projection/model.hpp"
#include "stereogrid/config.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

class Cpu;
struct Reference;

/// u-disparity occupancy to a Cartesian grid (eq. 16): a cell takes the largest occupancy of the bins that speak for
/// it, 0.5 where none does. `occupancy` is (D, W); the grid may lie anywhere in the vehicle frame.
///
/// Footprint::overlap: every bin whose footprint (depth [f·b/(d+½), f·b/(d−½)], columns u ± ½) shares an area with the
/// cell. Footprint::centre: the bins whose centre lies in the cell, and the bin that holds the cell's centre.
void project(Cpu& cpu, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             Footprint footprint, View<float> cells);
void project(Reference& reference, View<const float> occupancy, const BinGeometry& bins, const GridInVehicle& grid,
             Footprint footprint, View<float> cells);

}  // namespace stereogrid
