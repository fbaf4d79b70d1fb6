// SPDX-License-Identifier: Apache-2.0
//
// Disparities, points and images. The scan, on the rules of REP 117: a number for an obstacle, +inf for free, NaN for
// unknown.
#include "stereogrid/error.hpp"
#include "stereogrid/level_mapping.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/points.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using sensor_msgs::LaserScan;
using sensor_msgs::PointCloud2;
using stereo_msgs::DisparityImage;

// An obstacle at (120, 40), road at (90, 80).
FrameResult with_stages(const Rig& rig = small_rig()) {
  FrameResult result{small_result()};
  result.ground.height_m = 1.5;
  result.stages.obstacle_disparity = Image<float>{rig.width_px, rig.height_px};
  result.stages.road_disparity = Image<float>{rig.width_px, rig.height_px};
  result.stages.possible.resize(64);
  result.stages.obstacle_disparity(120, 40) = 12.5f;
  result.stages.road_disparity(90, 80) = 10.25f;
  return result;
}

float float_at(const std::vector<std::uint8_t>& data, std::size_t offset) {
  float value{0};
  std::memcpy(&value, data.data() + offset, sizeof(value));
  return value;
}

float disparity_at(const DisparityImage& message, int u, int v) {
  return float_at(message.image.data, static_cast<std::size_t>(v) * message.image.step + 4 * static_cast<unsigned>(u));
}

TEST(DisparityMessage, HasDisparitiesOfObstaclesAndRoad) {
  const auto message{sent_on<DisparityImage>("/stereo_grid/disparity", with_stages())};
  EXPECT_EQ(message.image.encoding, "32FC1");
  EXPECT_EQ(message.image.width, 200u);
  EXPECT_EQ(message.image.height, 100u);
  EXPECT_EQ(message.image.step, 800u);
  ASSERT_EQ(message.image.data.size(), 80'000u);
  EXPECT_EQ(disparity_at(message, 120, 40), 12.5f);
  EXPECT_EQ(disparity_at(message, 90, 80), 10.25f);
  EXPECT_EQ(message.header.frame_id, "stereo_left_optical");
  EXPECT_EQ(message.image.header.frame_id, "stereo_left_optical");
  EXPECT_EQ(message.f, 100);
  EXPECT_EQ(message.t, 0.5);
  EXPECT_EQ(message.valid_window.width, 200u);
  EXPECT_EQ(message.max_disparity, 64);
}

// For readers, values below min_disparity are invalid; 0 is not below 0 and would be infinitely far away.
TEST(DisparityMessage, HasLessThanTheLeastDisparityWhereThereIsNone) {
  const auto message{sent_on<DisparityImage>("/stereo_grid/disparity", with_stages())};
  EXPECT_LT(disparity_at(message, 0, 0), message.min_disparity);
  EXPECT_GE(disparity_at(message, 120, 40), message.min_disparity);
}

TEST(DisparityMessage, OfAPitchedCameraIsOfTheLevelOne) {
  Rig rig{small_rig()};
  rig.camera_pitch_rad = 0.2;
  const Rig level{LevelMapping{rig}.level_rig()};
  ASSERT_NE(level, rig);
  const auto message{sent_on<DisparityImage>("/stereo_grid/disparity", with_stages(level), {}, {}, rig)};
  EXPECT_EQ(message.header.frame_id, "stereo_left_optical_level");
  EXPECT_EQ(message.image.height, static_cast<std::uint32_t>(level.height_px));
}

TEST(DisparityMessage, OfAnotherRigIsRefused) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  FrameResult result{with_stages()};
  result.stages.obstacle_disparity = Image<float>{100, 100};
  EXPECT_THROW(messages.send(result, {}), InputError);
}

const FrameMessagesOptions all_points{.points_voxel_m = 0};

TEST(PointMessage, HasThePointsOfTheResult) {
  const FrameResult result{with_stages()};
  const std::vector<LabelledPoint> points{points_of(result, small_rig())};
  const auto message{sent_on<PointCloud2>("/stereo_grid/points", result, {}, all_points)};
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(message.header.frame_id, "base_link");
  EXPECT_EQ(message.width, 2u);
  EXPECT_EQ(message.height, 1u);
  EXPECT_EQ(message.row_step, 2 * message.point_step);
  ASSERT_EQ(message.data.size(), message.row_step);
  EXPECT_FALSE(message.is_bigendian);
  for (std::size_t i{0}; i < points.size(); ++i) {
    const std::size_t at{i * message.point_step};
    const std::array<float, 3> expected{points[i].x_m, points[i].y_m, points[i].z_m};
    for (std::size_t axis{0}; axis < 3; ++axis) {
      EXPECT_EQ(message.fields.at(axis).name, std::string{"xyz"[axis]});
      EXPECT_EQ(message.fields.at(axis).datatype, 7);
      EXPECT_EQ(float_at(message.data, at + message.fields.at(axis).offset), expected[axis]);
    }
    EXPECT_EQ(message.fields.at(3).name, "label");
    EXPECT_EQ(message.fields.at(3).datatype, 2);
    EXPECT_EQ(message.data[at + message.fields.at(3).offset], static_cast<std::uint8_t>(points[i].label));
  }
}

TEST(PointMessage, OfALabelHasItsPointsAlone) {
  const FrameResult result{with_stages()};
  const auto all{sent_on<PointCloud2>("/stereo_grid/points", result, {}, all_points)};
  std::vector<std::uint8_t> joined;
  for (const char* topic : {"/stereo_grid/obstacle_points", "/stereo_grid/ground_points"}) {
    const auto message{sent_on<PointCloud2>(topic, result, {}, all_points)};
    EXPECT_EQ(message.header.frame_id, "base_link");
    EXPECT_EQ(message.width, 1u);
    EXPECT_EQ(message.row_step, 16u);
    ASSERT_EQ(message.data.size(), 16u);
    EXPECT_EQ(message.data[12], topic == std::string{"/stereo_grid/ground_points"} ? 1 : 2);
    joined.insert(joined.end(), message.data.begin(), message.data.end());
  }
  const bool begins_with_ground{all.data.at(12) == 1};
  if (begins_with_ground) std::rotate(joined.begin(), joined.begin() + 16, joined.end());
  EXPECT_EQ(joined, all.data);
}

// Walls and road in every pixel, within and beyond a grid of 20 × 20 m.
FrameResult dense_result() {
  FrameResult result{with_stages()};
  result.vehicle.geometry = {0, -10, 0.5, 40, 40};
  result.observed = result.vehicle.occupancy = Image<float>{40, 40, 0.5f};
  for (int v{0}; v < 100; ++v) {
    for (int u{0}; u < 200; ++u) {
      Image<float>& stage{v < 60 ? result.stages.obstacle_disparity : result.stages.road_disparity};
      stage(u, v) = 2 + 0.1f * static_cast<float>(v % 60) + 0.01f * static_cast<float>(u % 7);
    }
  }
  return result;
}

using Voxel = std::array<int, 4>;

// Voxels of a cloud within x of 20 m and y of ±10 m, with the label, and the number of points in each.
std::map<Voxel, int> voxels_of(const PointCloud2& cloud, float side_m) {
  std::map<Voxel, int> voxels;
  for (std::size_t at{0}; at < cloud.data.size(); at += cloud.point_step) {
    const auto axis = [&](std::size_t i) { return float_at(cloud.data, at + 4 * i); };
    if (axis(0) < 0 || axis(0) >= 20 || std::abs(axis(1)) >= 10) continue;
    const auto cell = [&](std::size_t i) {
      return static_cast<int>(std::floor(static_cast<double>(axis(i)) / static_cast<double>(side_m)));
    };
    ++voxels[{cell(0), cell(1), cell(2), cloud.data[at + 12]}];
  }
  return voxels;
}

TEST(PointMessage, HasOnePointOfEachLabelInEachVoxelOfTheGrid) {
  const FrameResult result{dense_result()};
  const auto all{sent_on<PointCloud2>("/stereo_grid/points", result, {}, all_points)};
  const auto filtered{sent_on<PointCloud2>("/stereo_grid/points", result, {}, {.points_voxel_m = 0.5})};
  ASSERT_EQ(all.width, 20'000u);
  const std::map<Voxel, int> expected{voxels_of(all, 0.5f)};
  const std::map<Voxel, int> found{voxels_of(filtered, 0.5f)};
  EXPECT_EQ(filtered.width, found.size()) << "one outside the grid, or two in a voxel";
  EXPECT_TRUE(std::ranges::equal(expected, found, {}, &std::pair<const Voxel, int>::first,
                                 &std::pair<const Voxel, int>::first));
  EXPECT_LT(filtered.width, all.width / 4);
  const auto point = [](const PointCloud2& cloud, std::size_t i) {
    return std::vector<std::uint8_t>(cloud.data.begin() + static_cast<std::ptrdiff_t>(16 * i),
                                     cloud.data.begin() + static_cast<std::ptrdiff_t>(16 * i + 16));
  };
  std::set<std::vector<std::uint8_t>> measured;
  for (std::size_t i{0}; i < all.width; ++i) measured.insert(point(all, i));
  for (std::size_t i{0}; i < filtered.width; ++i) EXPECT_TRUE(measured.contains(point(filtered, i))) << i;
}

TEST(PointMessage, FitsTheReceiveBufferOfLinux) {
  FrameResult result{dense_result()};
  result.vehicle.geometry = {0, -200, 10, 40, 40};
  const auto cloud{sent_on<PointCloud2>("/stereo_grid/points", result, {}, {.points_voxel_m = 0.01})};
  EXPECT_LE(cloud.data.size(), 128'000u);
  EXPECT_GT(cloud.data.size(), 20'000u);
  for (const double side_m : {-1.0, 0.001, 11.0, std::numeric_limits<double>::quiet_NaN()}) {
    Recorder recorder;
    EXPECT_THROW((FrameMessages{recorder, small_rig(), {.points_voxel_m = side_m}}), ConfigError) << side_m;
  }
}

TEST(ImageMessages, AreLeftOutWithoutStagesAndPicture) {
  Recorder recorder;
  FrameMessages{recorder, small_rig()}.send(small_result(), {});
  EXPECT_EQ(recorder.type_of("/stereo_grid/disparity"), "no such topic");
  EXPECT_EQ(recorder.type_of("/stereo_grid/points"), "no such topic");
  EXPECT_EQ(recorder.type_of("/stereo_grid/left/image_annotated/compressed"), "no such topic");
}

TEST(ImageMessages, HaveThePictureAsItIs) {
  const std::array<std::byte, 3> jpeg{std::byte{0xff}, std::byte{0xd8}, std::byte{0}};
  const auto message{sent_on<sensor_msgs::CompressedImage>("/stereo_grid/left/image_annotated/compressed",
                                                           small_result(),
                                                           {.left_jpeg = [&](int) { return std::span{jpeg}; }})};
  EXPECT_EQ(message.format, "jpeg");
  EXPECT_EQ(message.header.frame_id, "stereo_left_optical");
  EXPECT_THAT(message.data, testing::ElementsAre(0xff, 0xd8, 0));
}

// 20 m × 20 m, all seen free; the rig's beams end at its sides after 14.1 m.
FrameResult all_free() {
  FrameResult result{small_result()};
  result.vehicle.geometry = {0, -10, 0.2, 100, 100};
  result.vehicle.occupancy = result.observed = Image<float>{100, 100, 0.1f};
  return result;
}

LaserScan scan_of(const FrameResult& result, const Rig& rig = small_rig()) {
  return sent_on<LaserScan>("/stereo_grid/scan", result, {}, {}, rig);
}

float range_at(const LaserScan& scan, double bearing_rad) {
  const double beam{(bearing_rad - static_cast<double>(scan.angle_min)) / static_cast<double>(scan.angle_increment)};
  return scan.ranges.at(static_cast<std::size_t>(std::lround(beam)));
}

void set(FrameResult& result, Point2 place, float occupancy) {
  const auto cell{result.vehicle.geometry.cell_at(place).value()};
  result.vehicle.occupancy(cell.ix, cell.iy) = occupancy;
}

TEST(LaserScanMessage, CoversTheFieldOfView) {
  const LaserScan scan{scan_of(all_free())};
  EXPECT_EQ(scan.header.frame_id, "base_link");
  EXPECT_NEAR(scan.angle_min, -std::numbers::pi / 4, 1e-6);
  EXPECT_NEAR(scan.angle_max, std::numbers::pi / 4, 1e-6);
  EXPECT_NEAR(scan.angle_min + static_cast<float>(scan.ranges.size() - 1) * scan.angle_increment, scan.angle_max, 1e-4);
  EXPECT_NEAR(scan.range_max, 10 * std::numbers::sqrt2, 1e-4);
  EXPECT_LE(scan.range_max * scan.angle_increment, 0.2f);
  EXPECT_TRUE(scan.intensities.empty());
}

TEST(LaserScanMessage, IsInfiniteWhereAllIsSeenFree) {
  for (const float range : scan_of(all_free()).ranges) EXPECT_EQ(range, std::numeric_limits<float>::infinity());
}

TEST(LaserScanMessage, IsUnknownWhereNothingWasSeen) {
  FrameResult result{all_free()};
  result.vehicle.occupancy.fill(0.5f);
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, HasTheNearestObstacleOfEachBearing) {
  FrameResult result{all_free()};
  set(result, {8.1, 0.1}, 0.9f);
  set(result, {12.1, 0.1}, 0.9f);
  const LaserScan scan{scan_of(result)};
  EXPECT_NEAR(range_at(scan, 0.1 / 8.1), 8.1, 0.2);
  EXPECT_EQ(range_at(scan, 0.2), std::numeric_limits<float>::infinity());
  EXPECT_EQ(range_at(scan, -0.2), std::numeric_limits<float>::infinity());
}

// So that a costmap marks that cell and no other.
TEST(LaserScanMessage, EndsWithinTheCellThatIsOccupied) {
  FrameResult result{all_free()};
  for (int iy{0}; iy < 100; ++iy) result.vehicle.occupancy(40, iy) = 0.9f;
  const LaserScan scan{scan_of(result)};
  for (std::size_t i{0}; i < scan.ranges.size(); ++i) {
    const double bearing_rad{static_cast<double>(scan.angle_min) +
                             static_cast<double>(i) * static_cast<double>(scan.angle_increment)};
    const double x_m{static_cast<double>(scan.ranges[i]) * std::cos(bearing_rad)};
    EXPECT_GE(x_m, 8.0 - 1e-4);
    EXPECT_LT(x_m, 8.2 + 1e-4);
  }
}

TEST(LaserScanMessage, IsUnknownBehindACellThatWasNotSeen) {
  FrameResult result{all_free()};
  set(result, {9.1, 0.1}, 0.5f);
  const LaserScan scan{scan_of(result)};
  EXPECT_TRUE(std::isnan(range_at(scan, 0.1 / 9.1)));
  EXPECT_EQ(range_at(scan, 0.2), std::numeric_limits<float>::infinity());
}

TEST(LaserScanMessage, HasAnObstacleBehindACellThatWasNotSeen) {
  FrameResult result{all_free()};
  set(result, {4.1, 0.1}, 0.5f);
  for (int iy{45}; iy < 56; ++iy) result.vehicle.occupancy(60, iy) = 0.9f;
  EXPECT_NEAR(range_at(scan_of(result), 0.1 / 4.1), 12.1, 0.15);
}

// 1.5 m above the ground and 26.6° down at the lowest row, the camera sees the ground from 3 m on.
TEST(LaserScanMessage, AsksNothingOfTheGroundBelowTheImage) {
  FrameResult result{all_free()};
  for (const auto [ix, iy] : raster(15, 100)) result.vehicle.occupancy(ix, iy) = 0.5f;
  for (const float range : scan_of(result).ranges) EXPECT_EQ(range, std::numeric_limits<float>::infinity());
  for (int iy{0}; iy < 100; ++iy) result.vehicle.occupancy(16, iy) = 0.5f;
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, IsUnknownWhereTheCameraSeesNoGround) {
  Rig rig{small_rig()};
  rig.camera_pitch_rad = -0.5;
  for (const float range : scan_of(all_free(), rig).ranges) EXPECT_TRUE(std::isnan(range));
}

TEST(LaserScanMessage, IsUnknownOfAGridBesideItsView) {
  FrameResult result{all_free()};
  result.vehicle.geometry.y_min_m = 5;
  for (const float range : scan_of(result).ranges) EXPECT_TRUE(std::isnan(range));
}

// Result and rigs of cameras around the vehicle, whose fields of view have 90°, in a free grid of 20 × 20 m.
FrameResult seen_by_cameras(const std::vector<double>& yaws_rad) {
  FrameResult result{all_free()};
  result.vehicle.geometry = {-10, -10, 0.2, 100, 100};
  for (const double yaw_rad : yaws_rad) {
    FrameResult& camera{result.cameras.emplace_back()};
    camera.camera_name = "camera" + std::to_string(result.cameras.size() - 1);
    camera.rig = camera.level_rig = small_rig();
    camera.rig.camera_yaw_rad = camera.level_rig.camera_yaw_rad = yaw_rad;
  }
  return result;
}

TEST(LaserScanMessage, CoversTheFieldsOfViewOfAllCameras) {
  constexpr double pi{std::numbers::pi};
  const LaserScan rear{scan_of(seen_by_cameras({-pi / 2, -pi}))};
  EXPECT_NEAR(rear.angle_min, -1.25 * pi, 1e-6);
  EXPECT_NEAR(rear.angle_max, -0.25 * pi, 1e-6);
  FrameResult result{seen_by_cameras({0, pi / 2, pi, -pi / 2})};
  set(result, {-5, 0.1}, 0.9F);
  set(result, {0.1, 4}, 0.9F);
  const LaserScan scan{scan_of(result)};
  EXPECT_NEAR(scan.angle_max - scan.angle_min, 2 * pi, 1e-5);
  EXPECT_NEAR(scan.range_max, 10, 1e-4) << "square to the sides of the grid";
  const auto beam_at = [&](double bearing_rad) {
    const double beyond_rad{std::fmod(bearing_rad - static_cast<double>(scan.angle_min) + 4 * pi, 2 * pi)};
    return scan.ranges.at(
        static_cast<std::size_t>(std::lround(beyond_rad / static_cast<double>(scan.angle_increment))));
  };
  EXPECT_NEAR(beam_at(pi - 0.02), 4.9, 0.2);
  EXPECT_NEAR(beam_at(pi / 2 - 0.025), 4, 0.2);
  for (const double bearing_rad : {0.0, -pi / 2, 2.5, -2.5})
    EXPECT_TRUE(std::isinf(beam_at(bearing_rad))) << bearing_rad;
}

TEST(LaserScanMessage, IsUnknownBetweenViews) {
  constexpr double pi{std::numbers::pi};
  const LaserScan scan{scan_of(seen_by_cameras({0.6 * pi, -0.6 * pi}))};
  EXPECT_NEAR(scan.angle_max - scan.angle_min, 1.3 * pi, 1e-5) << "the wider gap is ahead";
  const auto middle = scan.ranges.size() / 2;
  EXPECT_TRUE(std::isnan(scan.ranges[middle])) << "behind";
  EXPECT_TRUE(std::isinf(scan.ranges[middle / 2]));
  EXPECT_TRUE(std::isinf(scan.ranges[middle + middle / 2]));
}

// A camera 2 m ahead of the vehicle's origin sees nothing beside itself.
TEST(LaserScanMessage, TakesPlacesOfCamerasIntoAccount) {
  Rig rig{small_rig()};
  rig.camera_x_m = 2;
  FrameResult result{all_free()};
  const LaserScan scan{scan_of(result, rig)};
  EXPECT_TRUE(std::isinf(range_at(scan, 0)));
  EXPECT_TRUE(std::isnan(range_at(scan, std::numbers::pi / 4))) << "outside of its view";
}

TEST(ImageMessages, OfSeveralCamerasAreBelowTheirNames) {
  FrameResult result{with_stages()};
  const FrameResult one{result};
  for (const char* const name : {"front", "rear"}) {
    FrameResult& camera{result.cameras.emplace_back(one)};
    camera.camera_name = name;
    camera.rig = camera.level_rig = small_rig();
  }
  result.cameras[1].rig.camera_yaw_rad = result.cameras[1].level_rig.camera_yaw_rad = std::numbers::pi;
  const std::array<std::byte, 1> jpeg{std::byte{7}};
  const messages::FrameFacts facts{.left_jpeg = [&](int camera) {
    return camera == 0 ? std::span<const std::byte>{} : std::span<const std::byte>{jpeg};
  }};
  Recorder recorder;
  FrameMessages messages{recorder,
                         small_rig(),
                         {.topics = {"left/camera_info", "left/image_annotated/compressed", "disparity", "tf_static"}}};
  messages.send(result, facts);
  EXPECT_EQ(recorder.type_of("/stereo_grid/left/camera_info"), "no such topic");
  EXPECT_EQ(recorder.last<sensor_msgs::CameraInfo>("/stereo_grid/front/left/camera_info").header.frame_id,
            "front_stereo_left_optical");
  EXPECT_EQ(recorder.count("/stereo_grid/front/left/image_annotated/compressed"), 0u);
  EXPECT_THAT(recorder.last<sensor_msgs::CompressedImage>("/stereo_grid/rear/left/image_annotated/compressed").data,
              testing::ElementsAre(7));
  EXPECT_EQ(recorder.last<stereo_msgs::DisparityImage>("/stereo_grid/rear/disparity").header.frame_id,
            "rear_stereo_left_optical");
  std::vector<std::string> frames;
  for (const auto& one_of : recorder.last<tf2_msgs::TFMessage>("/tf_static").transforms)
    frames.push_back(one_of.child_frame_id);
  EXPECT_THAT(frames, testing::ElementsAre("front_stereo_left_optical", "rear_stereo_left_optical"));
}

TEST(LaserScanMessage, EndsWhereTheFirstBeamLeavesTheGrid) {
  FrameResult result{all_free()};
  set(result, {15.1, 0.1}, 0.9f);  // within the grid, behind the range
  EXPECT_EQ(range_at(scan_of(result), 0), std::numeric_limits<float>::infinity());
  Rig narrow{small_rig()};
  narrow.focal_px = 400;
  narrow.camera_height_m = 1;
  const LaserScan scan{scan_of(result, narrow)};
  EXPECT_NEAR(scan.range_max, 20, 1e-4);
  EXPECT_NEAR(range_at(scan, 0.1 / 15.1), 15.1, 0.15);
}

}  // namespace
}  // namespace stereogrid::messages::test
