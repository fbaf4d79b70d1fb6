// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/grid.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::test {
namespace {

constexpr float nan{std::numeric_limits<float>::quiet_NaN()};

TEST(Grid, CellsAndPlaces) {
  const GridGeometry grid{-1, 2, 0.5, 4, 3};
  EXPECT_DOUBLE_EQ(grid.centre(0, 0).x, -0.75);
  EXPECT_DOUBLE_EQ(grid.centre(3, 2).y, 3.25);
  for (int iy{0}; iy < grid.ny; ++iy) {
    for (int ix{0}; ix < grid.nx; ++ix) EXPECT_EQ(grid.cell_at(grid.centre(ix, iy)), (CellIndex{ix, iy}));
  }
  EXPECT_EQ(grid.cell_at({-1, 2}), (CellIndex{0, 0})) << "the lower edges belong to a cell";
  EXPECT_EQ(grid.cell_at({1, 2.1}), std::nullopt) << "the upper ones do not";
  EXPECT_EQ(grid.cell_at({0, 1.999}), std::nullopt);
  EXPECT_EQ(grid.cell_at({-1e300, 2}), std::nullopt);
  EXPECT_EQ(grid.cell_at({static_cast<double>(nan), 2}), std::nullopt);
}

TEST(Grid, WhatIsKnown) {
  for (const float p : {0.0f, 0.44f, 0.56f, 1.0f}) EXPECT_TRUE(is_known(p)) << p;
  for (const float p : {0.46f, 0.5f, 0.54f, nan}) EXPECT_FALSE(is_known(p)) << p;
}

TEST(OccupancyValues, Percent) {
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::percent)}; };
  EXPECT_EQ(value(0), 0);
  EXPECT_EQ(value(0.02f), 2);
  EXPECT_EQ(value(0.7f), 70);
  EXPECT_EQ(value(1), 100);
  EXPECT_EQ(value(0.5f), -1);
  EXPECT_EQ(value(nan), -1);
  EXPECT_EQ(value(7), 100);
}

TEST(OccupancyValues, Trinary) {
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::trinary)}; };
  EXPECT_EQ(value(0.1f), 0);
  EXPECT_EQ(value(0.4f), -1);
  EXPECT_EQ(value(0.6f), -1);
  EXPECT_EQ(value(0.66f), 100);
}

// Nav2's static layer takes 100 for an obstacle, 99 for "inscribed" and -1 for unknown.
TEST(OccupancyValues, Nav2) {
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::nav2)}; };
  EXPECT_EQ(value(0.1f), 0);
  EXPECT_EQ(value(0.7f), 100);
  EXPECT_EQ(value(0.5f), -1);
  int before{0};
  for (int i{0}; i <= 1000; ++i) {
    const float p{static_cast<float>(i) / 1000};
    if (!is_known(p)) continue;
    EXPECT_NE(value(p), 99) << p;
    EXPECT_GE(value(p), before) << p;
    before = value(p);
  }
  EXPECT_GT(value(0.36f), 0);
  EXPECT_LE(value(0.64f), 98);
}

TEST(OccupancyValues, Autoware) {
  const auto value = [](float p) { return int{occupancy_value(p, OccupancyScale::autoware)}; };
  EXPECT_EQ(value(0), 1);
  EXPECT_EQ(value(1), 99);
  EXPECT_EQ(value(0.7f), 70);
  EXPECT_EQ(value(0.5f), 50);
  EXPECT_EQ(value(nan), 50);
}

TEST(OccupancyValues, RowsFollowEachOther) {
  Image<float> occupancy{3, 2, 0.5f};
  occupancy(2, 0) = 1;
  occupancy(0, 1) = 0;
  EXPECT_EQ(occupancy_values(occupancy.view(), OccupancyScale::percent),
            (std::vector<std::int8_t>{-1, -1, 100, 0, -1, -1}));
}

}  // namespace
}  // namespace stereogrid::test
