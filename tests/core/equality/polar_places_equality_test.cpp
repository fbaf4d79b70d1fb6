// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Places of cells in the terrain's polar grid by vectors, on every instruction set of this machine, against plain
// loops.
#include <gtest/gtest.h>

#include "plain_places.hpp"
#include "targets.hpp"

namespace stereogrid::test {
namespace {

constexpr PolarGeometry camera{410, 123, 256.5F, 512, 63, 0.1F, 1040, 16};

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
          const PolarPlaces expected{plain_places(camera, cells, 3, step, iy)};
          EXPECT_EQ(places.x, expected.x);
          EXPECT_EQ(places.ring, expected.ring);
          EXPECT_EQ(places.first, expected.first);
          EXPECT_EQ(places.last, expected.last);
        }
      }
    }
  }
}

}  // namespace
}  // namespace stereogrid::test
