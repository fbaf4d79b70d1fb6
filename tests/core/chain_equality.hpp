// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "stereogrid/pipeline.hpp"

namespace stereogrid::test {

/// NaN, too.
inline bool have_equal_bits(const Image<float>& a, const Image<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

inline void expect_equal(const GridLayers& a, const GridLayers& b) {
  EXPECT_EQ(a.geometry, b.geometry);
  for (const auto layer :
       {&GridLayers::occupancy, &GridLayers::velocity_x, &GridLayers::velocity_y, &GridLayers::age_s,
        &GridLayers::velocity_xx, &GridLayers::velocity_xy, &GridLayers::velocity_yy, &GridLayers::moving}) {
    EXPECT_TRUE(have_equal_bits(a.*layer, b.*layer));
  }
}

inline void expect_equal(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.ground, b.ground);
  EXPECT_EQ(a.stages.obstacle_disparity, b.stages.obstacle_disparity);
  EXPECT_EQ(a.stages.road_disparity, b.stages.road_disparity);
  EXPECT_EQ(a.stages.possible, b.stages.possible);
  EXPECT_EQ(a.stages.visible, b.stages.visible);
  EXPECT_EQ(a.stages.observed, b.stages.observed);
  EXPECT_EQ(a.stages.occupancy_smooth, b.stages.occupancy_smooth);
  EXPECT_EQ(a.observed, b.observed);
  expect_equal(a.vehicle, b.vehicle);
  expect_equal(a.world, b.world);
  ASSERT_EQ(a.obstacles.size(), b.obstacles.size());
  for (std::size_t i{0}; i < a.obstacles.size(); ++i) {
    EXPECT_EQ(a.obstacles[i].id, b.obstacles[i].id);
    EXPECT_EQ(a.obstacles[i].x_m, b.obstacles[i].x_m);
    EXPECT_EQ(a.obstacles[i].y_m, b.obstacles[i].y_m);
    EXPECT_EQ(a.obstacles[i].vx_mps, b.obstacles[i].vx_mps);
    EXPECT_EQ(a.obstacles[i].vy_mps, b.obstacles[i].vy_mps);
  }
}

}  // namespace stereogrid::test
