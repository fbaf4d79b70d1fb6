// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/points.hpp"

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::test {
namespace {

const Rig rig{64, 48, 50, 31.5, 20.25, 0.4, 1.3, 0, 0};

FrameResult result_with_images() {
  FrameResult result;
  result.ground = {1.4, 0.02, -0.03};
  result.stages.obstacle_disparity = result.stages.road_disparity = Image<float>{rig.width_px, rig.height_px};
  return result;
}

TEST(Points, LieWhereTheDisparitySays) {
  FrameResult result{result_with_images()};
  result.ground = {1.4, 0, 0};
  result.stages.obstacle_disparity(40, 10) = 4;  // 50 · 0.4 / 4 = 5 m
  result.stages.road_disparity(10, 30) = 2;
  const std::vector<LabelledPoint> points{points_of(result, rig)};
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].label, PointLabel::obstacle);
  EXPECT_NEAR(points[0].x_m, 5, 1e-6);
  EXPECT_NEAR(points[0].y_m, -(40 - 31.5) * 5 / 50, 1e-6);
  EXPECT_NEAR(points[0].z_m, 1.4 - (10 - 20.25) * 5 / 50, 1e-6);
  EXPECT_EQ(points[1].label, PointLabel::road);
  EXPECT_NEAR(points[1].x_m, 10, 1e-6);
  EXPECT_GT(points[1].y_m, 0);
}

TEST(Points, OfTheRoadHaveNoHeight) {
  FrameResult result{result_with_images()};
  const RoadPlane plane{road_plane(rig, result.ground)};
  for (const auto [u, v] : raster(0, rig.width_px, 24, rig.height_px)) {
    result.stages.road_disparity(u, v) = static_cast<float>(std::max(0.0, plane.disparity(u, v)));
  }
  const std::vector<LabelledPoint> points{points_of(result, rig)};
  EXPECT_GT(points.size(), 1000u);
  for (const LabelledPoint& point : points) ASSERT_NEAR(point.z_m, 0, 1e-4);
}

TEST(Points, ThereAreNoneOfAFrameThatCannotBeReliedOn) {
  FrameResult result{result_with_images()};
  result.stages.obstacle_disparity(40, 10) = 4;
  for (const FrameStatus status : {FrameStatus::few_matches, FrameStatus::road_unknown}) {
    result.status = {FrameStatus::pose_missing, status};
    EXPECT_TRUE(points_of(result, rig).empty());
  }
  result.status = {FrameStatus::pose_missing};
  EXPECT_EQ(points_of(result, rig).size(), 1u);
}

TEST(Points, NeedTheStagesAndTheirRig) {
  FrameResult result{result_with_images()};
  Rig larger{rig};
  larger.width_px = 65;
  EXPECT_THROW(static_cast<void>(points_of(result, larger)), InputError);
  result.stages = {};
  EXPECT_THROW(static_cast<void>(points_of(result, rig)), InputError);
}

TEST(ClampedToInt, IsTheCastWhereThatIsDefined) {
  for (const double value : {0.0, -0.0, 0.999, -0.999, 1.0, -1.5, 16383.7, -5e8, 999'999'999.9, -999'999'999.9}) {
    EXPECT_EQ(clamped_to_int(value), static_cast<int>(value)) << value;
  }
}

TEST(ClampedToInt, EndsWhereTwoOfThemAndAnIndexCanStillBeAdded) {
  constexpr double infinity{std::numeric_limits<double>::infinity()};
  for (const double value : {1e9, 2147483647.0, 2147483648.0, 1e300, infinity}) {
    EXPECT_EQ(clamped_to_int(value), far_int) << value;
    EXPECT_EQ(clamped_to_int(-value), -far_int) << value;
  }
  EXPECT_LT(2LL * far_int + 100'000'000, std::numeric_limits<int>::max());
}

TEST(ClampedToInt, OfNoNumberIsZero) {
  EXPECT_EQ(clamped_to_int(std::nan("")), 0);
  EXPECT_EQ(clamped_to_int(std::nan(""), 5), 0);
}

TEST(ClampedToInt, TakesAnotherLimit) {
  EXPECT_EQ(clamped_to_int(4.9, 5), 4);
  EXPECT_EQ(clamped_to_int(5.9, 5), 5);
  EXPECT_EQ(clamped_to_int(-7, 5), -5);
}

}  // namespace
}  // namespace stereogrid::test
