// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rays/rays.hpp"

namespace stereogrid {

/// project_rays for rows begin … end − 1 of a grid.
void project_ray_rows(const RaySums<Host>& sums, int most_columns, const BinGeometry& geometry,
                      const GridInVehicle& grid, int begin, int end, View<float> cells);

}  // namespace stereogrid
