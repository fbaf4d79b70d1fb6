// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "filter/filter.hpp"

namespace stereogrid {
namespace {

constexpr float free_p{0.1f};
constexpr float hidden{0.5f};
constexpr float shown{0.9f};

struct Corrected {
  float occupancy;
  float moving;
};

// The middle cell of 5 × 5, observed as `here`, the rows below it as `below`, the others as `beside`.
Corrected corrected(float here, float beside, float below, float occupancy, float moving = 0, double x_min_m = 8) {
  Image<float> observed{5, 5, beside};
  for (int y{0}; y < 2; ++y) std::fill_n(observed.row(y), 5, below);
  observed(2, 2) = here;
  GridLayers layers{grid_layers({x_min_m, 0, 0.2, 5, 5})};
  layers.occupancy(2, 2) = occupancy;
  layers.moving(2, 2) = moving;
  correct_by_frame(observed.view(), 0, 5, layers);
  return {layers.occupancy(2, 2), layers.moving(2, 2)};
}

float after_factor(float occupancy, float factor) {
  return factor * occupancy / (factor * occupancy + 1 - occupancy);
}

TEST(CorrectByFrame, LowersTheOddsOfObstaclesBesideGround) {
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, shown, 0.9f).occupancy, after_factor(0.9f, 0.25f));
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, free_p, 0.7f).occupancy, 0.5f) << "never free";
  EXPECT_FLOAT_EQ(corrected(free_p, free_p, free_p, 0.7f).occupancy, 0.7f) << "the filter has seen that itself";
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, shown, 0.9f, 0, 4).occupancy, 0.9f) << "it has left the image";
}

TEST(CorrectByFrame, LowersThoseAtTheBorderOfAnObstacleThatTheFrameShows) {
  EXPECT_FLOAT_EQ(corrected(0.8f, free_p, shown, 0.9f).occupancy, after_factor(0.9f, 0.5f * 0.55f));
  EXPECT_FLOAT_EQ(corrected(0.85f, free_p, shown, 0.9f).occupancy, after_factor(0.9f, 0.55f));
  EXPECT_FLOAT_EQ(corrected(0.6f, free_p, free_p, 0.6f).occupancy, 0.6f) << "a pole of one cell stays";
  EXPECT_FLOAT_EQ(corrected(0.8f, shown, shown, 0.9f).occupancy, 0.9f);
}

// Cells in a row ahead of the vehicle.
TEST(CorrectByFrame, LowersThoseAtTheNearEdgeOfAnObstacleWithoutGround) {
  const auto on_ray = [](float before, float two_before, float here, float behind) {
    Image<float> observed{5, 1, hidden};
    observed(0, 0) = two_before;
    observed(1, 0) = before;
    observed(2, 0) = here;
    observed(3, 0) = behind;
    GridLayers layers{grid_layers({8, -0.1, 0.2, 5, 1})};
    layers.occupancy(2, 0) = 0.9f;
    correct_by_frame(observed.view(), 0, 1, layers);
    return layers.occupancy(2, 0);
  };
  EXPECT_FLOAT_EQ(on_ray(hidden, hidden, 0.8f, 0.9f), after_factor(0.9f, 0.55f));
  EXPECT_FLOAT_EQ(on_ray(hidden, hidden, 0.9f, 0.8f), 0.9f) << "the strongest cell is the obstacle";
  EXPECT_FLOAT_EQ(on_ray(0.6f, hidden, 0.8f, 0.9f), 0.9f) << "the edge is one cell before";
  EXPECT_FLOAT_EQ(on_ray(hidden, 0.6f, 0.8f, 0.9f), 0.9f) << "and here two cells";
}

TEST(CorrectByFrame, RaisesThoseOfHiddenCellsInsideAnObstacle) {
  EXPECT_FLOAT_EQ(corrected(hidden, shown, shown, 0.9f).occupancy, after_factor(0.9f, 2.5f));
  EXPECT_FLOAT_EQ(corrected(hidden, shown, shown, 0.55f).occupancy, 0.55f) << "unknown stays unknown";
}

TEST(CorrectByFrame, LeavesNothingFreeWhereAnObstacleIs) {
  EXPECT_FLOAT_EQ(corrected(shown, free_p, free_p, 0.3f).occupancy, 0.5f);
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, free_p, 0.3f, 0.25f).occupancy, 0.5f);
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, free_p, 0.3f, 0.15f).occupancy, 0.3f);
  EXPECT_FLOAT_EQ(corrected(free_p, free_p, free_p, 0.3f, 0.25f).occupancy, 0.3f);
}

TEST(CorrectByFrame, DropsWeakMemoryOfGroundBesideAnObstacle) {
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, shown, 0.3f).occupancy, 0.5f);
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, shown, 0.15f).occupancy, 0.15f) << "certain ground stays";
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, 0.58f, 0.3f).occupancy, 0.3f) << "the neighbour is uncertain";
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, free_p, 0.3f).occupancy, 0.3f);
  EXPECT_FLOAT_EQ(corrected(free_p, free_p, shown, 0.3f).occupancy, 0.3f) << "the frame shows ground";
}

TEST(CorrectByFrame, KeepsMovingMassWithinTheOccupancy) {
  EXPECT_FLOAT_EQ(corrected(hidden, free_p, free_p, 0.7f, 0.6f).moving, 0.5f);
}

}  // namespace
}  // namespace stereogrid
