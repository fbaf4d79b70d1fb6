// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Evidence for and against a frame's road plane, on disparities that are computed from planes.
#include "ground/frame_validator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ground/plane_numbers.hpp"
#include "images/patch.hpp"

namespace stereogrid::test {
namespace {

const Rig rig{640, 360, 425, 320, 140, 0.2, 1.0, 0, 0};

RoadPlane plane_of(double height_m, double roll_rad = 0) {
  Ground ground;
  ground.height_m = height_m;
  ground.roll_rad = roll_rad;
  return road_plane(rig, ground);
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
