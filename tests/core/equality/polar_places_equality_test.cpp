// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Places of cells in the terrain's polar grid by vectors, on every instruction set of this machine, against plain
// loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

#include "ground/relief.hpp"
#include "targets.hpp"
#include "terrain/polar_places.hpp"

namespace stereogrid::test {
namespace {

constexpr PolarGeometry camera{410, 123, 256.5F, 512, 63, 0.1F, 1040, 16};

int sector_at(float ahead_m, float left_m) {
  const float u{camera.cx_px - camera.focal_px * left_m / ahead_m};
  return static_cast<int>(std::clamp(u, -1.0F * sector_px, camera.width_px) / sector_px + 1) - 1;
}

void expect_place(const CellPlaces& cells, int ix, int iy, const PolarPlaces& found, std::size_t i) {
  const float x{cells.x_of(ix, iy)};
  const float y{cells.y_of(ix, iy)};
  const float ahead_m{std::max(x, camera.half_m)};
  const int first{std::max(sector_at(ahead_m, y + camera.half_m), 0)};
  const int right{sector_at(ahead_m, y - camera.half_m)};
  const int last{std::max({right - 1, sector_at(ahead_m, y), right < first ? -1 : first})};
  const float ring{camera.focal_baseline_pxm / ahead_m * camera.ring_places_per_px};
  EXPECT_EQ(x, found.x[i]);
  EXPECT_EQ(static_cast<int>(std::min(ring, camera.ring_places)), found.ring[i]);
  EXPECT_EQ(first, found.first[i]);
  EXPECT_EQ(x > camera.half_m ? std::min(last, camera.last_sector) : -1, found.last[i]);
}

TEST(PolarPlacesEquality, OnEveryInstructionSet) {
  const GridGeometry grid{-4, -12, 0.2, 120, 120};
  for (const double yaw_rad : {0.0, 0.7, -2.9}) {
    const CellPlaces cells{grid_in_vehicle(grid, {0.3, -0.1, yaw_rad}), {0, 0}, 1};
    for (const std::int64_t target : vector_targets()) {
      const ForcedTarget forced{target};
      SCOPED_TRACE(name_of_target(target));
      for (int iy{0}; iy < grid.ny; iy += 7) {
        for (const int step : {1, 5}) {
          PolarPlaces places{};
          find_places(camera, cells, 3, step, iy, places);
          for (int i{0}; i < PolarPlaces::size; ++i) {
            expect_place(cells, 3 + step * i, iy, places, static_cast<std::size_t>(i));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
