// SPDX-License-Identifier: Apache-2.0
//
// Kinds of gaps behind ground, on rows of disparities as a car's camera sees them (docs/terrain.md, gaps).
#include "terrain/gaps.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace stereogrid::test {
namespace {

/// Camera 1 m above level ground, f = 425 px, f·B = 85 px·m; a step is 0.15 m. All three sectors have the same rows.
class Gaps : public testing::Test {
 protected:
  static constexpr int horizon{180};
  static constexpr int rows{360};
  static constexpr float per_row{1 / 425.0f};

  static float tangent_of(int row) { return static_cast<float>(row - horizon) * per_row; }
  /// First row, upwards, above the ground at range `x`.
  static int row_over(float x) { return horizon + static_cast<int>(1 / (x * per_row)); }
  /// Disparity in a row of the plane z = z_at_x + slope·(range − x).
  [[nodiscard]] float of_plane(int row, float z, float slope = 0, float x = 0) const {
    const float range{(1 - z + slope * x) / (tangent_of(row) + slope)};
    return camera_.focal_baseline_pxm / range;
  }
  [[nodiscard]] SectorRows sector() const {
    return {disparity_.data(), nullptr, nullptr, nullptr, nullptr, nullptr, tangent_of(0), per_row, horizon + 1, rows};
  }

  /// Level ground up to `edge_m`, behind it the plane.
  Gap classified(float edge_m, float z, float slope, float sigma_px) {
    const int edge{row_over(edge_m)};
    for (int v{horizon + 1}; v < rows; ++v) {
      disparity_[static_cast<std::size_t>(v)] = v > edge ? of_plane(v, 0) : of_plane(v, z, slope, edge_m);
    }
    return classify_gap(camera_, limits_, {sector(), sector(), sector()}, {edge, edge_m, 0, 0, sigma_px, 9});
  }

  TerrainCamera camera_{{640, 360, 425, 320, horizon, 0.2, 1.0, 0, 0}, [] {
                          Ground ground;
                          ground.height_m = 1;
                          return ground;
                        }()};
  TerrainLimits limits_{0.15f, 0.364f, 1.8f, 0.25f, 0.105f};
  std::vector<float> disparity_ = std::vector<float>(rows);
};

// 1.5 px of disparity; the noise is lower.
TEST_F(Gaps, LowerLevelGroundWithinAStepIsABridge) {
  const Gap gap{classified(5, -0.1f, 0, 0.2f)};
  EXPECT_EQ(gap.kind, GapKind::bridge);
  EXPECT_NEAR(gap.landing_z, -0.1, 0.02);
  EXPECT_NEAR(gap.landing_x, 5.47, 0.02);
}

TEST_F(Gaps, LowerGroundByMoreThanAStepIsADropWhereItIsNear) {
  EXPECT_EQ(classified(5, -0.3f, 0, 0.2f).kind, GapKind::drop);
  EXPECT_EQ(classified(5, -3, 0, 0.2f).kind, GapKind::drop);
  EXPECT_EQ(classified(12, -3, 0, 0.2f).kind, GapKind::unknown) << "a hidden slope of 5 degrees explains it";
}

TEST_F(Gaps, RisingGroundBehindASmallStepIsABridge) {
  EXPECT_EQ(classified(5, -0.1f, 0.2f, 0.2f).kind, GapKind::bridge);
}

TEST_F(Gaps, UprightWallsBehindAreDropsIfTheyAreFartherThanTheNoise) {
  EXPECT_EQ(classified(5, -10.1f, 20, 0.2f).kind, GapKind::drop);
  EXPECT_EQ(classified(5, -10.1f, 20, 1).kind, GapKind::none);
}

// The line of sight to the edge of a rise is flatter than drop_slope.
TEST_F(Gaps, UprightWallsBehindARiseAreDropsIfTheyBeginAStepBelowItsLine) {
  constexpr float rise{0.2f};
  const auto behind_rise = [&](float wall_m) {
    const float edge_m{7};
    const float z{rise * (edge_m - 3)};
    const int edge{horizon + static_cast<int>((1 - z) / (edge_m * per_row))};
    for (int v{horizon + 1}; v < rows; ++v)
      disparity_[static_cast<std::size_t>(v)] = v > edge ? of_plane(v, z, rise, edge_m) : 85 / wall_m;
    return classify_gap(camera_, limits_, {sector(), sector(), sector()}, {edge, edge_m, z, rise, 0.2f, 9});
  };
  EXPECT_EQ(behind_rise(8.2f).kind, GapKind::drop);
  EXPECT_NE(behind_rise(7.4f).kind, GapKind::drop);
}

TEST_F(Gaps, OneSectorOfThreeShowsTheSurfaceBehind) {
  static_cast<void>(classified(5, -0.1f, 0, 0.2f));
  std::vector<float> empty(rows);
  SectorRows none{sector()};
  none.disparity = empty.data();
  EXPECT_EQ(classify_gap(camera_, limits_, {none, sector(), none}, {row_over(5), 5, 0, 0, 0.2f, 9}).kind,
            GapKind::bridge);
}

}  // namespace
}  // namespace stereogrid::test
