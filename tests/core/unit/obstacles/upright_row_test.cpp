// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "obstacles/segmentation/upright_row.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

namespace stereogrid::test {
namespace {

// On level ground, seen from 1 m above it with the horizon in this row's place: every disparity is upright.
TEST(UprightRow, WhatLiesBetweenTwoSurfacesIsLeftOut) {
  const UprightRow limits{
      .nearest_px = 64, .farthest_px = 1, .road_px = 0, .road_per_px = 0, .lowest_share = 0.8f, .highest_share = -1};
  std::vector<float> row(40, 20.0f);
  std::fill(row.begin() + 20, row.end(), 10.0f);
  row[19] = 15;  // a window across the edge
  row[3] = 15;   // between nothing
  row[8] = 0;
  UprightPixels pixels;
  plain::find_upright(row.data(), 40, 0, 40, limits, pixels);
  std::vector<int> left_out;
  for (int u{0}, i{0}; u < 40; ++u) {
    if (i < pixels.size && pixels.columns[i] == u) {
      EXPECT_EQ(pixels.disparities[i++], row[static_cast<std::size_t>(u)]);
    } else {
      left_out.push_back(u);
    }
  }
  EXPECT_THAT(left_out, ::testing::ElementsAre(8, 19));
}

TEST(UprightRow, WhatIsNoHigherThanTheRoadOrTooFarIsNone) {
  const UprightRow limits{.nearest_px = 64,
                          .farthest_px = 4,
                          .road_px = 8,
                          .road_per_px = 0.1f,
                          .lowest_share = 0.8f,
                          .highest_share = 0.5f};
  for (const auto& [u, d, is_upright] : {std::tuple{0, 10.1f, true},
                                         {0, 9.9f, false},
                                         {5, 10.7f, true},
                                         {5, 10.5f, false},
                                         {0, 63.0f, true},
                                         {0, 64.0f, false},
                                         {-50, 4.1f, true},
                                         {-50, 4.0f, false}}) {
    EXPECT_EQ(limits.is_upright(u, d), is_upright) << u << " " << d;
  }
  EXPECT_TRUE(limits.is_below_highest(0, 10.1f));
  EXPECT_FALSE(limits.is_below_highest(4, 63));
}

}  // namespace
}  // namespace stereogrid::test
