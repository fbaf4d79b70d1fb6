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

// The window's cells are those of the vehicle's grid, if the vehicle is at the origin. All are observed as `observed`.
FrameResult result_of(const GridGeometry& geometry, float observed) {
  FrameResult result;
  result.observed = Image<float>{geometry.nx, geometry.ny, observed};
  result.vehicle = grid_layers(geometry);
  result.world = result.vehicle;
  return result;
}

// The middle cell of 5 × 5, observed as `here`, the rows below it as `below`, the others as `beside`.
Corrected corrected(float here, float beside, float below, float occupancy, float moving = 0, double x_min_m = 8) {
  FrameResult result{result_of({x_min_m, 0, 0.2, 5, 5}, beside)};
  for (int y{0}; y < 2; ++y) std::fill_n(result.observed.row(y), 5, below);
  result.observed(2, 2) = here;
  result.vehicle.occupancy(2, 2) = occupancy;
  result.vehicle.moving(2, 2) = moving;
  correct_by_frame({}, true, 0, 5, result);
  return {result.vehicle.occupancy(2, 2), result.vehicle.moving(2, 2)};
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
  const auto on_ray = [](float before, float two_before, float here, float behind, bool is_widened = true) {
    FrameResult result{result_of({8, -0.1, 0.2, 5, 1}, hidden)};
    result.observed(0, 0) = two_before;
    result.observed(1, 0) = before;
    result.observed(2, 0) = here;
    result.observed(3, 0) = behind;
    result.vehicle.occupancy(2, 0) = 0.9f;
    correct_by_frame({}, is_widened, 0, 1, result);
    return result.vehicle.occupancy(2, 0);
  };
  EXPECT_FLOAT_EQ(on_ray(hidden, hidden, 0.8f, 0.9f), after_factor(0.9f, 0.55f));
  EXPECT_FLOAT_EQ(on_ray(hidden, hidden, 0.9f, 0.8f), 0.9f) << "the strongest cell is the obstacle";
  EXPECT_FLOAT_EQ(on_ray(0.6f, hidden, 0.8f, 0.9f), 0.9f) << "the edge is one cell before";
  EXPECT_FLOAT_EQ(on_ray(hidden, 0.6f, 0.8f, 0.9f), 0.9f) << "and here two cells";
  EXPECT_FLOAT_EQ(on_ray(hidden, hidden, 0.8f, 0.9f, false), 0.9f) << "external disparities have sharp edges";
}

// The middle cell of the vehicle's grid on the corner of four cells of the window: three quarters are of others than
// the nearest.
TEST(CorrectByFrame, TakesFromASurerFrameWhatIsInterpolatedFromOtherCells) {
  const auto on_corner = [](float observed, float occupancy, float in_window) {
    FrameResult result{result_of({8, 0, 0.2, 3, 3}, observed)};
    result.vehicle.occupancy(1, 1) = occupancy;
    result.world.occupancy.fill(occupancy);
    result.world.occupancy(2, 1) = in_window;
    correct_by_frame({0.1, -0.1, 0}, true, 0, 3, result);
    return result.vehicle.occupancy(1, 1);
  };
  EXPECT_NEAR(on_corner(0.98f, 0.7f, 0.99f), 0.91f, 1e-5);
  EXPECT_NEAR(on_corner(0.02f, 0.3f, 0.01f), 0.09f, 1e-5);
  EXPECT_FLOAT_EQ(on_corner(0.98f, 0.7f, 0.8f), 0.8f) << "no cell of the window is surer";
  EXPECT_FLOAT_EQ(on_corner(0.02f, 0.3f, 0.2f), 0.2f);
  EXPECT_FLOAT_EQ(on_corner(0.7f, 0.98f, 0.99f), 0.98f) << "the filter is surer";
  EXPECT_FLOAT_EQ(on_corner(0.7f, 0.52f, 0.99f), 0.52f) << "unknown stays unknown";
  EXPECT_FLOAT_EQ(on_corner(0.1f, 0.7f, 0.01f), 0.7f) << "they contradict each other";
  EXPECT_FLOAT_EQ(corrected(0.98f, 0.98f, 0.98f, 0.7f).occupancy, 0.7f) << "cells that coincide";
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
