// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>

#include "fusion/fusion.hpp"
#include "fusion/model.hpp"

namespace stereogrid {
namespace {

// Another source must not make a cell so certain that nothing could change it any more.
constexpr double surest{0.999};

template <class Pool>
void add(const ObservedGrid& other, Point2 at, double confidence, Pool& pool) {
  const double ix{(at.x - other.geometry.x_min_m) / other.geometry.cell_size_m};
  const double iy{(at.y - other.geometry.y_min_m) / other.geometry.cell_size_m};
  if (!(ix >= 0 && ix < other.geometry.nx && iy >= 0 && iy < other.geometry.ny)) return;
  const int x{static_cast<int>(ix)};
  const int y{static_cast<int>(iy)};
  const double p{std::clamp(static_cast<double>(other.occupancy(x, y)), 1 - surest, surest)};
  pool.add(p, confidence * (other.confidence.empty() ? 1.0 : static_cast<double>(other.confidence(x, y))));
}

template <class Pool>
void fuse_rows_by(std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
                  View<float> cells, int begin, int end) {
  for (int iy{begin}; iy < end; ++iy) {
    for (int ix{0}; ix < cells.width; ++ix) {
      Pool pool;
      pool.add(static_cast<double>(cells(ix, iy)), config.stereo_confidence);
      for (const ObservedGrid& other : others) add(other, grid.centre(ix, iy), config.other_confidence, pool);
      cells(ix, iy) = static_cast<float>(pool.probability());
    }
  }
}

}  // namespace

void fuse_rows(std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
               View<float> cells, int begin, int end) {
  if (config.rule == FusionRule::linear) {
    fuse_rows_by<LinearPool>(others, grid, config, cells, begin, end);
  } else {
    fuse_rows_by<IndependentPool>(others, grid, config, cells, begin, end);
  }
}

void fuse(Reference&, std::span<const ObservedGrid> others, const GridInVehicle& grid, const FusionConfig& config,
          View<float> cells) {
  if (others.empty()) return;
  fuse_rows(others, grid, config, cells, 0, cells.height);
}

}  // namespace stereogrid
