// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
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

/// `p`, but not surer than that.
STEREOGRID_HD inline double limited(double p) {
  return p < 1 - surest ? 1 - surest : (p > surest ? surest : p);
}

/// n-th root of a positive number, n > 0, by square roots alone: equal to the bit on all back ends.
STEREOGRID_HD inline double root(double number, int n) {
  constexpr int rounds_max{40};  // the error shrinks to at most 3/8 in each
  int halvings{0};
  while (1 << halvings < n) ++halvings;
  double result{1};
  for (int round{0}; round < rounds_max; ++round) {
    double next{number};  // result^n = number where result^(2^halvings) = number · result^(2^halvings − n)
    for (int i{n}; i < 1 << halvings; ++i) next *= result;
    for (int i{0}; i < halvings; ++i) next = std::sqrt(next);
    if (next == result) break;
    result = next;
  }
  return result;
}

/// Maximum number of cameras of a pipeline.
constexpr int cameras_max{8};

/// Logarithmic opinion pool of the cameras that see a cell: their mean log odds, 0.5 without any. Their errors have
/// common causes, so that two observations are no more evidence than one.
struct CameraPool {
  double odds{1};
  float seen{0.5f};  ///< by the last of them
  int count{0};

  STEREOGRID_HD void add(float p) {
    if (p == 0.5f) return;
    const double sure{limited(static_cast<double>(p))};
    odds *= sure / (1 - sure);
    seen = p;
    ++count;
  }
  [[nodiscard]] STEREOGRID_HD float probability() const {
    if (count < 2) return seen;
    const double mean{root(odds, count)};
    return static_cast<float>(mean / (1 + mean));
  }
};

/// Adds the other source's cell at the place `at`, if there is one.
STEREOGRID_HD inline void add(const OtherCells& other, Point2 at, IndependentPool& pool) {
  const GridGeometry& grid{other.geometry};
  const double ix{(at.x - grid.x_min_m) / grid.cell_size_m};
  const double iy{(at.y - grid.y_min_m) / grid.cell_size_m};
  if (!(ix >= 0 && ix < grid.nx && iy >= 0 && iy < grid.ny)) return;
  const std::ptrdiff_t cell{static_cast<std::ptrdiff_t>(iy) * grid.nx + static_cast<std::ptrdiff_t>(ix)};
  pool.add(limited(static_cast<double>(other.occupancy[cell])),
           other.confidence == nullptr ? 1.0 : static_cast<double>(other.confidence[cell]));
}

/// A cell of the window that stays occupied although the frame cannot observe it.
struct RetainedCell {
  int cell;         ///< iy · nx + ix of the window
  float occupancy;  ///< least P(occupied) that counts as observed
};

/// Most cells that are held at a time.
constexpr int retained_cells_max{8192};

}  // namespace stereogrid
