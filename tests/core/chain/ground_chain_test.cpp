// SPDX-License-Identifier: Apache-2.0
//
// The ground of whole drives through scenes, whose road is flat and whose camera is where its rig says, level or
// pitched.
#include "chain_run.hpp"
#include "geometry/road_plane.hpp"
#include "ground_drive.hpp"
#include "stereogrid/level_mapping.hpp"
#include "stereogrid/points.hpp"

namespace stereogrid::test {
namespace {

constexpr const char* street{"street?width=400&height=250"};

struct Errors {
  double height{0};
  double pitch{0};
  double roll{0};
};

// Root mean square of the errors, each divided by its standard deviation.
Errors normalised_errors(const Rig& rig, const std::vector<Ground>& grounds) {
  Errors sum;
  for (const Ground& ground : grounds) {
    EXPECT_TRUE(ground.estimated);
    sum.height += std::pow((ground.height_m - rig.camera_height_m) / ground.height_sigma_m, 2);
    sum.pitch += std::pow((ground.pitch_rad - rig.camera_pitch_rad) / ground.pitch_sigma_rad, 2);
    sum.roll += std::pow((ground.roll_rad - rig.camera_roll_rad) / ground.roll_sigma_rad, 2);
  }
  const auto frames{static_cast<double>(grounds.size())};
  return {std::sqrt(sum.height / frames), std::sqrt(sum.pitch / frames), std::sqrt(sum.roll / frames)};
}

TEST(GroundChain, RecoversFromAWrongCalibration) {
  const Scene scene{street};
  const std::vector<StereoFrame> frames{frames_of(scene, 7)};
  const std::vector<Ground> right{grounds_of(frames, scene.rig())};
  for (const WrongBy& by : {WrongBy{1, 0, 0}, WrongBy{-1, 0, 0}, WrongBy{2, 0, 0}, WrongBy{-2, 0, 0}, WrongBy{0, 1, 0},
                            WrongBy{0, -1, 0}, WrongBy{0, 0, 0.1}, WrongBy{0, 0, -0.1}, WrongBy{1, -1, 0.1}}) {
    SCOPED_TRACE(testing::Message() << by.pitch_deg << "° " << by.roll_deg << "° " << by.height_m << " m");
    expect_recovered(right, grounds_of(frames, wrong(scene.rig(), by)));
  }
}

TEST(GroundChain, FollowsAJumpOfThePitchAndBack) {
  const Scene scene{street};
  const std::vector<StereoFrame> frames{frames_of(scene, 9)};
  for (const double pitch_deg : {1.0, -1.0, 2.0}) {
    const std::vector<Ground> grounds{grounds_of(frames, scene.rig(), {3, 6, pitch_deg * degree})};
    for (std::size_t i{0}; i < grounds.size(); ++i) {
      if (i == 3 || i == 6) continue;  // the filter may take a frame
      EXPECT_NEAR(grounds[i].pitch_rad / degree, i > 3 && i < 6 ? pitch_deg : 0, 0.3) << "frame " << i;
    }
  }
}

TEST(GroundChain, ErrorsAreAboutAsLargeAsItSays) {
  for (const char* text : {street, "crossing", "empty"}) {
    const Scene scene{text};
    const Errors errors{normalised_errors(scene.rig(), grounds_of(frames_of(scene, 8), scene.rig()))};
    for (const double error : {errors.height, errors.pitch, errors.roll}) {
      EXPECT_GT(error, 0.1) << text;
      EXPECT_LT(error, 2) << text;
    }
  }
}

// A wall on the left, a pavement 12 cm up on the right, and between them little but the van.
TEST(GroundChain, HoldsBehindAVanThatHidesTheRoad) {
  const Scene scene{"van"};
  const std::vector<Ground> grounds{grounds_of(frames_of(scene, 30), scene.rig())};
  for (const Ground& ground : grounds) {
    EXPECT_NEAR(ground.height_m, scene.rig().camera_height_m, 0.03);
    EXPECT_NEAR(ground.pitch_rad / degree, 0, 0.4);
    EXPECT_NEAR(ground.roll_rad / degree, 0, 0.4);
  }
  const Errors errors{normalised_errors(scene.rig(), grounds)};
  EXPECT_LT(errors.pitch, 3);
  EXPECT_LT(errors.height, 3);
}

TEST(GroundChain, AWallOverEverythingIsNoRoad) {
  const Scene scene{"wall"};
  const std::vector<Ground> grounds{grounds_of(frames_of(scene, 5), scene.rig())};
  for (const Ground& ground : grounds) {
    EXPECT_TRUE(ground.estimated);
    EXPECT_NEAR(ground.height_m, scene.rig().camera_height_m, 0.03);
    EXPECT_NEAR(ground.pitch_rad / degree, 0, 0.3);
  }
}

constexpr double pitch_deg{5};

struct PitchedDrive : testing::Test {
  PitchedDrive() {
    for (std::size_t i{0}; i < 3; ++i) result = &drive.step(i);
  }

  // Projection of a point of the road to the camera's image.
  [[nodiscard]] ImagePoint in_camera(double x_m, double y_m) const {
    const Rig& rig{drive.pipeline.next_rig()};
    const double c{std::cos(rig.camera_pitch_rad)};
    const double s{std::sin(rig.camera_pitch_rad)};
    const double depth{s * rig.camera_height_m + c * x_m};
    return {rig.cx_px - rig.focal_px * y_m / depth,
            rig.cy_px + rig.focal_px * (c * rig.camera_height_m - s * x_m) / depth};
  }

  Drive drive{"street?width=400&height=250&frames=3&pitch_deg=5"};
  const FrameResult* result{nullptr};
};

TEST_F(PitchedDrive, ARoadPointIsWhereTheGroundSays) {
  const Rig level_rig{LevelMapping{drive.pipeline.next_rig()}.level_rig()};
  const LevelMapping mapping{drive.pipeline.next_rig()};
  ASSERT_NEAR(drive.pipeline.next_rig().camera_pitch_rad, pitch_deg * degree, 1e-9);
  ASSERT_EQ(level_rig, mapping.level_rig());
  ASSERT_TRUE(result->ground.estimated);
  const RoadPlane road{road_plane(level_rig, result->ground)};
  const RoadPlane of_the_camera{road_plane(drive.pipeline.next_rig(), result->ground)};
  int matched{0};
  for (double x_m{5}; x_m < 13; x_m += 0.5) {
    for (const double y_m : {-1.5, -0.5, 0.5, 1.5}) {
      const ImagePoint camera{in_camera(x_m, y_m)};
      const std::optional<ImagePoint> level{mapping.level_from_camera(camera)};
      ASSERT_TRUE(level);
      const double disparity{level_rig.focal_px * level_rig.baseline_m / x_m};
      EXPECT_NEAR(road.disparity(level->u, level->v), disparity, 0.1) << x_m << " " << y_m;
      EXPECT_GT(std::abs(of_the_camera.disparity(camera.u, camera.v) - disparity), 1) << "the wrong rig would do, too";
      const float found{result->stages.road_disparity(static_cast<int>(std::lround(level->u)),
                                                      static_cast<int>(std::lround(level->v)))};
      if (found == 0) continue;
      ++matched;
      EXPECT_NEAR(found, disparity, 1);
    }
  }
  EXPECT_GT(matched, 20);
}

TEST_F(PitchedDrive, PointsOfTheRoadLieOnIt) {
  const std::vector<LabelledPoint> points{points_of(*result, result->level_rig)};
  std::vector<float> heights_m;
  for (const LabelledPoint& point : points) {
    if (point.label == PointLabel::road && point.x_m < 10) heights_m.push_back(std::abs(point.z_m));
  }
  ASSERT_GT(heights_m.size(), 1000u);
  const auto middle = heights_m.begin() + static_cast<std::ptrdiff_t>(heights_m.size() / 2);
  std::nth_element(heights_m.begin(), middle, heights_m.end());
  EXPECT_LT(*middle, 0.03);
  const auto is_high = [](const LabelledPoint& point) {
    return point.label == PointLabel::obstacle && point.z_m > 0.3;
  };
  EXPECT_GT(std::ranges::count_if(points, is_high), 1000);
}

}  // namespace
}  // namespace stereogrid::test
