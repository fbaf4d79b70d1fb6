// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "filter/model.hpp"
#include "observation/projection/model.hpp"

namespace stereogrid {

/// A grid's cells in cells of the window, from its corner on.
[[nodiscard]] STEREOGRID_HD inline CellPlaces places_in_window(const GridInVehicle& cells, const GridGeometry& window) {
  return {cells, {window.x_min_m, window.y_min_m}, window.cell_size_m};
}

[[nodiscard]] STEREOGRID_HD inline bool is_inside(const GridGeometry& window, float x, float y) {
  return x >= 0 && x < static_cast<float>(window.nx) && y >= 0 && y < static_cast<float>(window.ny);
}

/// Between the four cells around (x, y), in cells from the centre of the first; the border repeats. `at(x, y)`.
template <class At>
STEREOGRID_HD inline float interpolated(const At& at, int width, int height, float x, float y) {
  const auto within = [](int cell, int count) { return Min(Max(cell, 0), count - 1); };
  const float left{floorf(x)};
  const float low{floorf(y)};
  const int ix{static_cast<int>(left)};
  const int iy{static_cast<int>(low)};
  const auto value = [&](int cx, int cy) { return at(within(cx, width), within(cy, height)); };
  return among(value(ix, iy), value(ix + 1, iy), value(ix, iy + 1), value(ix + 1, iy + 1), x - left, y - low);
}

/// False: complete_cell() leaves a cell as it is. Without branches, for vectors.
STEREOGRID_HD inline bool may_complete(float age_s, float occupancy) {
  return !(age_s < INFINITY) & is_known(occupancy);
}

/// See complete_unobserved(): a cell at (x, y), in cells of the window from the corner of the first. `age_at(x, y)`.
template <class AgeAt>
STEREOGRID_HD inline void complete_cell(const AgeAt& age_at, const GridGeometry& window, float x, float y, float moving,
                                        float& age_s, float& occupancy) {
  if (!may_complete(age_s, occupancy)) return;
  const int left{static_cast<int>(floorf(x - 0.5f))};
  const int low{static_cast<int>(floorf(y - 0.5f))};
  for (int iy{low}; iy <= low + 1; ++iy) {
    for (int ix{left}; ix <= left + 1; ++ix)
      age_s = Min(age_s, age_at(Min(Max(ix, 0), window.nx - 1), Min(Max(iy, 0), window.ny - 1)));
  }
  if (age_s == INFINITY) occupancy = Min(occupancy, Max(moving, 0.5f));
}

}  // namespace stereogrid
