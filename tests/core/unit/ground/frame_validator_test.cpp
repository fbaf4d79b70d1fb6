// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Evidence for and against a frame's road plane, on disparities that are computed from planes.
#include "ground/frame_validator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/match_lattice.hpp"
#include "ground/fit.hpp"

namespace stereogrid::test {
namespace {

const Rig rig{640, 360, 425, 320, 140, 0.2, 1.0, 0, 0};

RoadPlane plane_of(double height_m, double roll_rad = 0) {
  Ground ground;
  ground.height_m = height_m;
  ground.roll_rad = roll_rad;
  return road_plane(rig, ground);
}

std::vector<GroundSample> samples_on(const RoadPlane& plane) {
  std::vector<GroundSample> samples;
  for (int v{6}; v < rig.height_px; v += 12) {
    for (int u{6}; u < rig.width_px; u += 12) {
      const auto disparity = static_cast<float>(plane.disparity(u, v));
      if (disparity > 0.5f) samples.push_back({static_cast<float>(u), static_cast<float>(v), disparity});
    }
  }
  return samples;
}

TEST(Matrix3, IsPositiveDefiniteIfAllLeadingMinorsAre) {
  EXPECT_TRUE(is_positive_definite(diagonal({{1, 2, 3}})));
  Matrix3 matrix{diagonal({{1, 1, 1}})};
  matrix[0][2] = matrix[2][0] = matrix[1][2] = matrix[2][1] = 0.6;
  EXPECT_TRUE(is_positive_definite(matrix));
  matrix[0][2] = matrix[2][0] = matrix[1][2] = matrix[2][1] = 0.9;
  EXPECT_FALSE(is_positive_definite(matrix));
}

TEST(Matrix3, SumsOfVectors) {
  const Vector3 sum{Vector3{{1, 2, 3}} + Vector3{{10, 20, 30}}};
  for (int i{0}; i < 3; ++i) EXPECT_EQ(sum[i], 11 * (i + 1));
}

TEST(FindPlane, FindsTheRollOfARoad) {
  const RoadPlane road{plane_of(1.0, 0.12)};
  RoadPlane found{plane_of(1.0)};
  GroundConfig gates;
  gates.roll_gate_deg = 10;
  ASSERT_TRUE(find_plane(rig, gates, samples_on(road), found));
  EXPECT_NEAR(found.per_u, road.per_u, 1e-3);
  EXPECT_NEAR(found.per_v, road.per_v, 1e-3);
}

// Road up to 4 m below the camera is a better plane, if enough samples lie on it.
TEST(FindPlane, ABetterPlaneMayBeFarFromTheGatesButHasTheSamples) {
  const std::vector<GroundSample> samples{samples_on(plane_of(3.6))};
  const auto all = static_cast<int>(samples.size());
  EXPECT_TRUE(has_better_plane(rig, samples, all / 2, plane_of(1.0)));
  EXPECT_FALSE(has_better_plane(rig, samples, all + 1, plane_of(1.0)));
  EXPECT_FALSE(has_better_plane(rig, samples, all / 2, plane_of(3.6)));
}

TEST(NearGround, HoldsWithAHundredSamplesOfWhichSixtyAreOnThePlane) {
  EXPECT_TRUE((NearGround{100, 60, 0}.holds()));
  EXPECT_FALSE((NearGround{100, 59, 0}.holds()));
  EXPECT_FALSE((NearGround{99, 99, 0}.holds()));
}

// The lowest row is 1.94 m away.
TEST(NearGround, IsThatUpToTheNearestDistanceAndAFifth) {
  const RoadPlane road{plane_of(1.0)};
  for (const double far_m : {2.4, 2.1}) {
    std::vector<GroundSample> samples{samples_on(road)};
    const double far_px{rig.focal_px * rig.baseline_m / far_m};
    for (GroundSample& sample : samples) sample.disparity *= sample.disparity < far_px ? 0.7f : 1.0f;
    const NearGround found{near_ground(rig, samples, road, road, nearest_part)};
    EXPECT_GT(found.samples, 100);
    EXPECT_EQ(found.on_plane == found.samples, far_m > 2.3) << far_m;
  }
}

// Matches of a road that falls away from some distance on, between two lines along the road.
struct FallingRoad {
  FallingRoad(double right_m, double left_m) {
    for (int v{0}; v < rig.height_px; ++v) {
      for (int u{0}; u < rig.width_px; ++u) {
        const double expected{road.disparity(u, v)};
        if (expected < 1) continue;
        const double y_m{(rig.cx_px - u) * rig.baseline_m / expected};
        const bool falls{rig.focal_px * rig.baseline_m / expected > 4 && y_m > right_m && y_m < left_m};
        matches.road(u, v) = static_cast<float>(falls ? expected / 2 : expected);
      }
    }
  }
  [[nodiscard]] double width_m() const { return width_falling_away({left.view(), left.view(), matches}, rig, road); }

  RoadPlane road{plane_of(1.0)};
  Image<std::uint8_t> left{rig.width_px, rig.height_px};
  Matches matches{rig.width_px, rig.height_px};
};

// The width is that at the third sample of a column, up to 1.4 times as far as the first.
TEST(FallingAway, IsGroundWithinAMetreOfTheVehiclesPath) {
  EXPECT_EQ(FallingRoad(0, 0).width_m(), 0);
  EXPECT_NEAR(FallingRoad(-0.5, 0.5).width_m(), 1.2, 0.2);
  EXPECT_NEAR(FallingRoad(-0.5, 3).width_m(), 1.8, 0.3);
  EXPECT_EQ(FallingRoad(1.2, 3).width_m(), 0);
}

TEST(TextureMatched, CountsPixelsWithTexture) {
  Image<std::uint8_t> left{rig.width_px, rig.height_px, 100};
  Matches matches{rig.width_px, rig.height_px};
  // stripes on the left half
  for (int v{0}; v < rig.height_px; ++v) {
    for (int u{0}; u < rig.width_px / 2; ++u) {
      left(u, v) = u / 3 % 2 == 0 ? 60 : 140;
      matches.road(u, v) = 10;
    }
  }
  const MatchedFrame frame{left.view(), left.view(), matches};
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 1);
  matches.road.fill(0);
  EXPECT_EQ(share_of_texture_matched(frame, 0, plane_of(1.0), 128), 0);
}

}  // namespace
}  // namespace stereogrid::test
