// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "filter/model.hpp"
#include "projection/model.hpp"

namespace stereogrid {

/// The centres of a grid's cells, in cells of the window from its corner on. In single precision: of whole steps along
/// the window exact, else to 1e-4 of a cell in windows of 1000.
struct CellsInWindow {
  float x;  ///< of the cell (0, 0)
  float y;
  float along;  ///< a step by ix is (along, across), a step by iy (−across, along)
  float across;

  STEREOGRID_HD CellsInWindow(const GridInVehicle& cells, const GridGeometry& window)
      : x{static_cast<float>((cells.centre(0, 0).x - window.x_min_m) / window.cell_size_m)},
        y{static_cast<float>((cells.centre(0, 0).y - window.y_min_m) / window.cell_size_m)},
        along{static_cast<float>(cells.cos_yaw * (cells.grid.cell_size_m / window.cell_size_m))},
        across{static_cast<float>(cells.sin_yaw * (cells.grid.cell_size_m / window.cell_size_m))} {}

  [[nodiscard]] STEREOGRID_HD float x_of(int ix, int iy) const {
    return (x - across * static_cast<float>(iy)) + along * static_cast<float>(ix);
  }
  [[nodiscard]] STEREOGRID_HD float y_of(int ix, int iy) const {
    return (y + along * static_cast<float>(iy)) + across * static_cast<float>(ix);
  }
};

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
