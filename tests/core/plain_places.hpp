// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "geometry/relief.hpp"
#include "terrain/polar_places.hpp"

namespace stereogrid::test {

/// find_places() without vectors.
inline PolarPlaces plain_places(const PolarGeometry& geometry, const CellPlaces& cells, int ix, int step, int iy) {
  PolarPlaces places;
  for (int i{0}; i < PolarPlaces::size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const float x{cells.x_of(ix + step * i, iy)};
    const float y{cells.y_of(ix + step * i, iy)};
    const float ahead_m{std::max(x, geometry.half_m)};
    const auto sector_at = [&](float left_m) {
      const float u{geometry.cx_px - geometry.focal_px * left_m / ahead_m};
      return static_cast<int>(std::clamp(u, -1.0F * sector_px, geometry.width_px) / sector_px + 1) - 1;
    };
    const int first{std::max(sector_at(y + geometry.half_m), 0)};
    const int right{sector_at(y - geometry.half_m)};
    const int last{std::max({right - 1, sector_at(y), right < first ? -1 : first})};
    const float place{geometry.focal_baseline_pxm / ahead_m * geometry.ring_places_per_px};
    places.x[k] = x;
    places.ring[k] = static_cast<int>(std::min(place, geometry.ring_places));
    places.first[k] = first;
    places.last[k] = x > geometry.half_m ? std::min(last, geometry.last_sector) : -1;
  }
  return places;
}

}  // namespace stereogrid::test
