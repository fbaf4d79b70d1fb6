// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "host_device.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/grid.hpp"

namespace stereogrid {

/// Pool of sources with independent errors: odds multiply, P = Π p / (Π p + Π (1 − p)). A source with confidence c
/// counts as ½ + c (p − ½).
struct IndependentPool {
  double occupied{1};
  double empty{1};

  STEREOGRID_HD void add(double p, double confidence) {
    const double weighted{0.5 + confidence * (p - 0.5)};
    occupied *= weighted;
    empty *= 1 - weighted;
  }
  [[nodiscard]] STEREOGRID_HD double probability() const {
    const double all{occupied + empty};
    return all > 0 ? occupied / all : 0.5;
  }
};

/// An ObservedGrid without its memory.
struct OtherCells {
  GridGeometry geometry;
  const float* occupancy;
  const float* confidence;  ///< null: 1
};

/// Limit of a source's probability: none makes a cell so certain that nothing could change it any more.
constexpr double surest{0.999};

/// Adds the other source's cell at the place `at`, if there is one.
STEREOGRID_HD inline void add(const OtherCells& other, Point2 at, IndependentPool& pool) {
  const GridGeometry& grid{other.geometry};
  const double ix{(at.x - grid.x_min_m) / grid.cell_size_m};
  const double iy{(at.y - grid.y_min_m) / grid.cell_size_m};
  if (!(ix >= 0 && ix < grid.nx && iy >= 0 && iy < grid.ny)) return;
  const std::ptrdiff_t cell{static_cast<std::ptrdiff_t>(iy) * grid.nx + static_cast<std::ptrdiff_t>(ix)};
  const double said{other.occupancy[cell]};
  const double p{said < 1 - surest ? 1 - surest : (said > surest ? surest : said)};
  pool.add(p, other.confidence == nullptr ? 1.0 : static_cast<double>(other.confidence[cell]));
}

/// A cell of the window that stays occupied although the frame cannot observe it.
struct RetainedCell {
  int cell;         ///< iy · nx + ix of the window
  float occupancy;  ///< least P(occupied) that counts as observed
};

/// Most cells that are held at a time.
constexpr int retained_cells_max{8192};

}  // namespace stereogrid
