// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stereogrid/image.hpp"

namespace stereogrid {

/// Where the cells of a grid lie. Cell (ix, iy) covers [x_min + ix·s, +s) × [y_min + iy·s, +s), in metres. Arrays over
/// a grid are Image<T> of width nx and height ny: [iy, ix], x fastest.
struct GridGeometry {
  double x_min_m{0};
  double y_min_m{0};
  double cell_size_m{0.2};
  int nx{0};
  int ny{0};

  friend bool operator==(const GridGeometry&, const GridGeometry&) = default;
};

/// What the filter knows about every cell of a grid. Velocities are relative to the ground, in the grid's own axes, of
/// what occupies the cell if something does.
struct GridLayers {
  GridGeometry geometry;
  Image<float> occupancy;   ///< P(occupied) in [0, 1]; 0.5 = unknown
  Image<float> velocity_x;  ///< m/s, mean
  Image<float> velocity_y;
  Image<float> age_s;          ///< time since the cell was last observed; inf = never
  Image<float> velocity_xx{};  ///< m²/s², covariance of the velocity
  Image<float> velocity_xy{};
  Image<float> velocity_yy{};
  Image<float> moving{};  ///< P(occupied by something that moves); P(by something that stands) = occupancy − moving
};

}  // namespace stereogrid
