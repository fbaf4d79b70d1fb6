// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../prelude.hpp"
#include "stereogrid/evaluation/scores.hpp"

namespace stereogrid::evaluation::testing {

/// Level camera 1.64 m high, one column per centimetre at 1 m: u = 100 − 100·y/x.
inline Rig small_rig() {
  return {.width_px = 201,
          .height_px = 101,
          .focal_px = 100,
          .cx_px = 100,
          .cy_px = 50,
          .baseline_m = 0.5,
          .camera_height_m = 1.64};
}

/// A line of metre cells straight ahead, from 0 to `cells`.
inline GridGeometry lane(int cells) {
  return {0, -0.5, 1, cells, 1};
}

/// Labels of a lane: '.' not scored, '0' free, '1' occupied, 'f' and 'o' the same but partly hidden.
inline Labels lane_labels(const std::string& cells) {
  const int n{static_cast<int>(cells.size())};
  Labels labels{lane(n), small_rig(), {n, 1, not_scored}, {n, 1}};
  for (int i{0}; i < n; ++i) {
    const char c{cells[static_cast<std::size_t>(i)]};
    labels.partly_hidden(i, 0) = c == 'f' || c == 'o' ? 1 : 0;
    if (c != '.') labels.cells(i, 0) = c == '1' || c == 'o' ? labelled_occupied : labelled_free;
  }
  return labels;
}

inline Image<float> lane_of(const std::vector<float>& probabilities) {
  Image<float> image{static_cast<int>(probabilities.size()), 1};
  std::copy(probabilities.begin(), probabilities.end(), image.begin());
  return image;
}

inline constexpr Band everything{0, 1000};

inline constexpr GridGeometry half_metre_grid{0, -5, 0.5, 48, 20};

inline std::vector<float> values_of(const Image<float>& image) {
  return {image.begin(), image.end()};
}

/// Largest and smallest probability of the cells whose centres are within `around_m` of x, y to the left.
struct Extremes {
  float smallest{1};
  float largest{0};
};
inline Extremes around(const Image<float>& cells, const GridGeometry& grid, double x_m, double y_m,
                       double around_m = 0.75) {
  Extremes found;
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) {
      const double x{grid.x_min_m + (ix + 0.5) * grid.cell_size_m};
      const double y{grid.y_min_m + (iy + 0.5) * grid.cell_size_m};
      if (std::abs(x - x_m) > around_m || std::abs(y - y_m) > around_m) continue;
      found.smallest = std::min(found.smallest, cells(ix, iy));
      found.largest = std::max(found.largest, cells(ix, iy));
    }
  }
  return found;
}

}  // namespace stereogrid::evaluation::testing
