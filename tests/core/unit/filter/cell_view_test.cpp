// SPDX-License-Identifier: Apache-2.0
//
// The camera's view of single cells: repetition and decay.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>

#include "filter/filter.hpp"

namespace stereogrid::test {
namespace {

// A camera of f·b = 90 px·m that has come 1 m nearer sees a point 12 m away by 5/8 px elsewhere, one 24 m away by 5/32.
TEST(CellView, IsRepeatedDependingOnTheParallaxOfTheCell) {
  const FilterConfig config;
  const FilterTables tables{config};
  const GridGeometry window{-10.1, -20.1, 0.2, 300, 300};
  const Pose2 camera{5, -3, 0.4};
  const auto repeated = [&](double parallax_px_m2, double x_m, double y_m) {
    const FilterStep step{step_of({config, tables, window, 0.1, {camera, 1, 1, parallax_px_m2}})};
    const CellIndex cell{*window.cell_at({x_m, y_m})};
    return view_of(step, cell.ix, cell.iy).repeated;
  };
  EXPECT_EQ(repeated(0, 17, -3), 1) << "a vehicle that stands";
  EXPECT_EQ(repeated(90, 17, -3), 0);
  EXPECT_NEAR(repeated(90, 29, -3), 1 - 90.0 / (24 * 24) / 0.5, 1e-3);
  EXPECT_NEAR(repeated(90, 5, 21), 1 - 90.0 / (24 * 24) / 0.5, 1e-3) << "whatever the direction";
  EXPECT_EQ(repeated(std::numeric_limits<double>::infinity(), 29, -3), 0) << "unknown";
}

// Cells in the field of view without matches decay faster than cells beside it.
TEST(CellView, DecayIsQuickerInTheField) {
  const FilterConfig config;
  const FilterTables tables{config};
  const GridGeometry window{-10.1, -20.1, 0.2, 300, 300};
  const auto decay = [&](const CameraView& view, Point2 at) {
    const FilterStep step{step_of({config, tables, window, 0.1, view})};
    const CellIndex cell{*window.cell_at(at)};
    return view_of(step, cell.ix, cell.iy).decay;
  };
  const auto within = [](double time_s) { return (1 - std::exp(-0.1 / time_s)) / 2; };
  const double in_view{within(config.decay_time_in_view_s)};
  const double beside{within(config.decay_time_s)};
  ASSERT_GT(in_view, beside);
  const CameraView ahead{{5, -3, 0}, 1, 0.5};  // 45° to the left, 27° to the right
  for (const Point2 at : {Point2{15, -3}, {15, 6}, {15, -7.5}}) EXPECT_NEAR(decay(ahead, at), in_view, 1e-6) << at.y;
  for (const Point2 at : {Point2{15, 8}, {15, -9}, {0, -3}}) EXPECT_NEAR(decay(ahead, at), beside, 1e-6) << at.y;
  const CameraView to_the_left{{5, -3, 1.5707963}, 1, 0.5};
  EXPECT_NEAR(decay(to_the_left, {5, 7}), in_view, 1e-6);
  EXPECT_NEAR(decay(to_the_left, {15, -3}), beside, 1e-6);
  EXPECT_NEAR(decay({}, {15, -3}), beside, 1e-6) << "nothing is known of the camera";
}

// A pixel of disparity is five cells deep at a distance of √(f·b · 5 cells/px); twice as far it is twenty cells deep.
TEST(CellView, DecayIsQuickerWhereAPixelIsDeeperThanFiveCells) {
  const FilterConfig config;
  const FilterTables tables{config};
  const auto decay = [&](double cell_size_m, double ahead_m) {
    const GridGeometry window{-10.1, -20.1, cell_size_m, 300, 300};
    const CameraView view{{-5, -16, 0}, 1, 1, std::numeric_limits<double>::infinity(), 100};
    const CellIndex cell{*window.cell_at({-5 + ahead_m, -16})};
    return view_of(step_of({config, tables, window, 0.1, view}), cell.ix, cell.iy).decay;
  };
  EXPECT_EQ(decay(0.2, 5), decay(0.2, 9.5));
  EXPECT_NEAR(decay(0.2, 20), 4 * decay(0.2, 5), 0.1 * decay(0.2, 5));
  EXPECT_LE(decay(0.2, 40), 0.5f) << "a cell is unknown at most";
  EXPECT_EQ(decay(0.05, 2), decay(0.05, 4.5));
  EXPECT_NEAR(decay(0.05, 9), 81.0 / 25 * decay(0.05, 2), 0.1 * decay(0.05, 2));
}

// The image shows the least height from 4 m ahead on. 2 m ahead, rays pass above a chain that stands; in the strip of
// the baseline's width along the left border only one camera sees it.
TEST(CellView, WhatStandsIsFreedOnlyWhereItIsSeenWholly) {
  const FilterConfig config;
  const FilterTables tables{config};
  const GridGeometry window{-10.1, -20.1, 0.2, 300, 300};
  const auto occupancy = [&](Point2 at, float standing, float observed, std::span<const CameraView> others = {}) {
    const CameraView view{{0, 0, 0}, 1, 1, std::numeric_limits<double>::infinity(), 100, 4, 0.5};
    const FilterStep step{step_of({config, tables, window, 0.1, view, nullptr, others})};
    const CellIndex cell{*window.cell_at(at)};
    const Likelihood likelihood{likelihood_of(tables.likelihood.data(), observed)};
    return joint_update(step, 0.95f, standing, 0.0f, likelihood, view_of(step, cell.ix, cell.iy)).occupancy;
  };
  EXPECT_LT(occupancy({6, 0}, 0.9f, 0.02f), 0.4f) << "seen wholly";
  EXPECT_GT(occupancy({2, 0}, 0.9f, 0.02f), 0.85f) << "too near";
  EXPECT_GT(occupancy({6, 5.8}, 0.9f, 0.02f), 0.85f) << "not seen by the right camera";
  EXPECT_LT(occupancy({6, -5.8}, 0.9f, 0.02f), 0.4f) << "seen by both";
  EXPECT_LT(occupancy({2, 0}, 0.3f, 0.02f), 0.4f) << "it moves, and leaves by itself";
  EXPECT_GT(occupancy({2, 0}, 0.9f, 0.98f), occupancy({2, 0}, 0.9f, 0.5f)) << "evidence for it counts";
  EXPECT_EQ(occupancy({2, 0}, 0.9f, 0.02f), occupancy({6, 0}, 0.9f, 0.5f)) << "as if not observed";
  const CameraView behind{{-4, 0, 0}, 1, 1, std::numeric_limits<double>::infinity(), 100, 4, 0.5};
  EXPECT_LT(occupancy({2, 0}, 0.9f, 0.02f, {&behind, 1}), 0.4f) << "another camera sees it wholly";
}

// Divides the odds by 4 in cells with a coarseness of 4, if the frame does not confirm the obstacle.
TEST(CellView, CoarseObstaclesNeedConfirmation) {
  const auto kept = [](float predicted, float observed) {
    return predicted * kept_where_coarse(predicted, 4.0f, observed / (1 - observed));
  };
  EXPECT_NEAR(kept(0.9f, 0.5f), 9.0 / 4 / (1 + 9.0 / 4), 1e-6);
  EXPECT_NEAR(kept(0.9f, 0.8f), 0.8, 1e-6) << "not below the observation";
  EXPECT_FLOAT_EQ(kept(0.9f, 0.95f), 0.9f);
  EXPECT_FLOAT_EQ(kept(0.7f, 0.1f), 0.5f) << "unknown at least: free is what is seen to be free";
  EXPECT_EQ(kept(0.3f, 0.9f), 0.3f);
  EXPECT_EQ(kept(1.0f, 0.5f), 1.0f);
}

}  // namespace
}  // namespace stereogrid::test
