// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "accuracy/truth_points.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stereogrid::bench {
namespace {

const Rig rig{600, 300, 700, 300, 120, 0.5, 1.65, 0, 0};

TruthPoint point(double u, double v, double disparity) {
  return {static_cast<float>(u), static_cast<float>(v), static_cast<float>(disparity), Surface::other, false};
}

/// Truth at a pixel: a road, and a wall 12 m ahead in the columns 200–400 that reaches up to row 60.
TruthPoint seen(const RoadPlane& plane, int u, int v) {
  const double wall{rig.focal_px * rig.baseline_m / 12};
  const bool is_wall{u >= 200 && u <= 400 && v >= 60 && plane.disparity(u, v) < wall};
  return point(u, v, is_wall ? wall : plane.disparity(u, v));
}

std::vector<TruthPoint> street(const RoadPlane& plane) {
  std::vector<TruthPoint> points;
  for (int v{0}; v < rig.height_px; v += 3) {
    for (int u{0}; u < rig.width_px; u += 2) {
      if (seen(plane, u, v).disparity > 1) points.push_back(seen(plane, u, v));
    }
  }
  return points;
}

TEST(TruthPoints, OfAScan) {
  const io::Transform camera_from_velodyne{0, -1, 0, 0.1, 0, 0, -1, -0.2, 1, 0, 0, -0.3};
  const std::vector<io::ScanPoint> scan{{10.3F, 1.1F, -1.2F, 0}, {2.2F, 0, 0, 0}, {-10, 0, 0, 0}, {10.3F, 9, 0, 0}};
  const auto points{points_of_scan(scan, camera_from_velodyne, rig)};
  ASSERT_EQ(points.size(), 1U);  // then one too near, one behind, one beside the image
  EXPECT_NEAR(points[0].u, 300 - 70, 1e-3);
  EXPECT_NEAR(points[0].v, 120 + 70, 1e-3);
  EXPECT_NEAR(points[0].disparity, 35, 1e-3);
}

TEST(TruthPoints, OfAnImage) {
  Image<float> disparity{4, 3};
  disparity(2, 1) = 7.5F;
  const auto points{points_of_image(disparity)};
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].u, 2);
  EXPECT_EQ(points[0].v, 1);
  EXPECT_EQ(points[0].disparity, 7.5F);
}

TEST(TruthPoints, OfASceneKeepTheirLabels) {
  FrameTruth truth;
  truth.disparity = Image<float>{80, 4, 5};
  truth.label = Image<std::uint8_t>{80, 4, 1};
  truth.seen_by_both = Image<std::uint8_t>{80, 4, 255};
  truth.label(40, 0) = 2;
  truth.label(79, 0) = 3;
  truth.seen_by_both(40, 0) = 0;
  const auto points{points_of_scene(truth)};
  ASSERT_EQ(points.size(), 319U);
  for (const TruthPoint& p : points) {
    if (p.u == 79 && p.v == 0) {
      EXPECT_EQ(p.surface, Surface::other);
    } else {
      EXPECT_EQ(p.surface, Surface::road);
      EXPECT_EQ(p.near_contact, std::abs(p.u - 40) <= contact_px) << p.u;  // to the hidden obstacle too
    }
  }
}

TEST(RemoveHidden, LeavesWhatTheLeftCameraSees) {
  std::vector<TruthPoint> points{street(road_plane(rig, {1.65, 0.01, 0.03, false}))};
  std::erase_if(points, [](const TruthPoint& p) { return p.v < 60; });
  const std::size_t all{points.size()};
  std::size_t beside_wall{0};
  const float wall{700 * 0.5F / 12};
  for (const TruthPoint& p : points) {
    const bool covered_for_right{p.disparity < wall && p.u - p.disparity > 200 - wall - 4 && p.u < 404};
    beside_wall += covered_for_right || (p.u > 190 && p.u < 410 && p.disparity < wall) ? 1 : 0;
  }
  remove_hidden(rig, points);
  EXPECT_GE(points.size(), all - beside_wall);
  EXPECT_LT(points.size(), all);
}

TEST(RemoveHidden, WhatTheLidarSeesOverTheTop) {
  const TruthPoint over_the_top{point(300, 97, 10)};
  const TruthPoint well_above{point(300, 90, 10)};
  const TruthPoint for_the_right_only{point(300 - 20 + 1, 120, 10)};  // at u − d = 271, where the wall has 270
  std::vector<TruthPoint> points{over_the_top, well_above, for_the_right_only};
  for (int v{101}; v < 140; v += 5) {
    for (int u{300}; u < 340; u += 2) points.push_back(point(u, v, 30));
  }
  const std::size_t of_wall{points.size() - 3};
  remove_hidden(rig, points);
  ASSERT_EQ(points.size(), of_wall + 1);
  EXPECT_EQ(points[0].v, 90);
}

TEST(FitRoad, FindsPitchAndRoll) {
  const Ground truth{1.7, 0.02, 0.03, false};
  const RoadPlane plane{road_plane(rig, truth)};
  const Ground found{ground_of(rig, fit_road(rig, street(plane)))};
  EXPECT_NEAR(found.height_m, truth.height_m, 0.005);
  EXPECT_NEAR(found.pitch_rad, truth.pitch_rad, 0.0005);
  EXPECT_NEAR(found.roll_rad, truth.roll_rad, 0.001);
}

TEST(FitRoad, StaysWithTheMountWhereNothingIsLow) {
  const RoadPlane found{fit_road(rig, {point(300, 50, 20), point(310, 40, 20)})};
  EXPECT_EQ(ground_of(rig, found).height_m, 1.65);
}

TEST(LabelByHeight, Bands) {
  const RoadPlane plane{road_plane(rig, {1.65, 0, 0, false})};
  const auto at_height{[&](double height_m, double depth_m) {
    return point(100, rig.cy_px + rig.focal_px * (1.65 - height_m) / depth_m, rig.focal_px * rig.baseline_m / depth_m);
  }};
  EXPECT_NEAR(height_above(plane, 1.65, at_height(0.7, 15)), 0.7, 1e-4);
  std::vector<TruthPoint> points{at_height(0.09, 10),  at_height(0.2, 10),  at_height(0.31, 10),
                                 at_height(-0.09, 10), at_height(-0.2, 10), at_height(1, 45)};
  label_by_height(rig, plane, points);
  EXPECT_EQ(points[0].surface, Surface::road);
  EXPECT_EQ(points[1].surface, Surface::other);
  EXPECT_EQ(points[2].surface, Surface::obstacle);
  EXPECT_EQ(points[3].surface, Surface::road);
  EXPECT_EQ(points[4].surface, Surface::other);
  EXPECT_EQ(points[5].surface, Surface::other);
  EXPECT_FALSE(points[2].near_contact);  // 15 rows apart
  std::vector<TruthPoint> close{at_height(0.05, 20), at_height(0.31, 20)};
  label_by_height(rig, plane, close);
  EXPECT_TRUE(close[0].near_contact);
  EXPECT_TRUE(close[1].near_contact);
}

TEST(TurnLevel, APointOfTheWorldFromTwoCameras) {
  Rig pitched{rig};
  pitched.camera_pitch_rad = 0.05;
  Rig level{rig};
  level.cy_px += 20;
  const auto project{[](double x, double y, double z) {
    return point(rig.cx_px + rig.focal_px * x / z, rig.cy_px + rig.focal_px * y / z, rig.focal_px * rig.baseline_m / z);
  }};
  const double s{std::sin(0.05)};
  const double c{std::cos(0.05)};
  const double x{1.2}, y{1.65}, z{9};  // level camera; in the image of the pitched one the point is higher
  std::vector<TruthPoint> points{project(x, y * c - z * s, y * s + z * c)};
  turn_level(pitched, level, points);
  TruthPoint expected{project(x, y, z)};
  expected.v += 20;  // the level image's own centre
  EXPECT_NEAR(points[0].u, expected.u, 1e-3);
  EXPECT_NEAR(points[0].v, expected.v, 1e-3);
  EXPECT_NEAR(points[0].disparity, expected.disparity, 1e-3);
}

TEST(KeepComparable, CutsBordersAndRange) {
  std::vector<TruthPoint> points{point(73, 5, 9), point(74, 5, 9), point(74, 5, 63), point(599.6, 5, 9),
                                 point(74, 299.4, 62.9)};
  keep_comparable(rig, 64, points);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[0].u, 74);
  EXPECT_EQ(points[1].disparity, 62.9F);
}

}  // namespace
}  // namespace stereogrid::bench
