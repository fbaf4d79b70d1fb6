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

}  // namespace stereogrid
