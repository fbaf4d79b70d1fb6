// SPDX-License-Identifier: Apache-2.0
//
// Transforms and odometry.
#include "stereogrid/level_mapping.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using nav_msgs::Odometry;
using ::testing::Each, ::testing::ElementsAre;
using tf2_msgs::TFMessage;
using Vector = std::array<double, 3>;

constexpr std::int64_t tenth_ns{100'000'000};

// A rotation's matrix, written out from its quaternion, times a vector.
Vector turned(const geometry_msgs::Quaternion& q, const Vector& v) {
  const auto [x, y, z] = v;
  return {(1 - 2 * (q.y * q.y + q.z * q.z)) * x + 2 * (q.x * q.y - q.z * q.w) * y + 2 * (q.x * q.z + q.y * q.w) * z,
          2 * (q.x * q.y + q.z * q.w) * x + (1 - 2 * (q.x * q.x + q.z * q.z)) * y + 2 * (q.y * q.z - q.x * q.w) * z,
          2 * (q.x * q.z - q.y * q.w) * x + 2 * (q.y * q.z + q.x * q.w) * y + (1 - 2 * (q.x * q.x + q.y * q.y)) * z};
}

void expect_near(const Vector& found, const Vector& expected) {
  for (std::size_t i{0}; i < 3; ++i) EXPECT_NEAR(found[i], expected[i], 1e-12) << "axis " << i;
}

/// Projection of a point of the vehicle frame to the left image, by the transform and the calibration alone.
ImagePoint drawn(const TFMessage& transforms, const sensor_msgs::CameraInfo& info, const Vector& in_vehicle) {
  const geometry_msgs::Transform& mounted{transforms.transforms.front().transform};
  const geometry_msgs::Quaternion& q{mounted.rotation};
  const Vector in_camera{
      turned({-q.x, -q.y, -q.z, q.w}, {in_vehicle[0] - mounted.translation.x, in_vehicle[1] - mounted.translation.y,
                                       in_vehicle[2] - mounted.translation.z})};
  const auto row = [&](std::size_t i) {
    return info.p[i] * in_camera[0] + info.p[i + 1] * in_camera[1] + info.p[i + 2] * in_camera[2] + info.p[i + 3];
  };
  return {row(0) / row(8), row(4) / row(8)};
}

TEST(CameraInfoMessage, AndTheTransformBringThePointsIntoTheImage) {
  for (const double pitch_rad : {0.0, 0.2}) {
    Rig rig{small_rig()};
    rig.camera_pitch_rad = pitch_rad;
    Recorder recorder;
    FrameMessages{recorder, rig}.send(small_result(), {.stamp_ns = 7});
    const auto info{recorder.last<sensor_msgs::CameraInfo>("/stereo_grid/left/camera_info")};
    EXPECT_EQ(info.header.frame_id, "stereo_left_optical");
    EXPECT_EQ(info.header.stamp.nanosec, 7u);
    EXPECT_EQ(info.width, 200u);
    EXPECT_EQ(info.height, 100u);
    EXPECT_EQ(info.distortion_model, "plumb_bob");
    EXPECT_EQ(info.d, std::vector<double>(5));
    EXPECT_EQ(info.k[0], rig.focal_px);
    const LevelMapping mapping{rig};
    const Rig& level{mapping.level_rig()};
    const auto expected{
        mapping.camera_from_level({level.cx_px - 2.0 / 10 * level.focal_px, level.cy_px + 1.5 / 10 * level.focal_px})};
    const ImagePoint found{drawn(recorder.last<TFMessage>("/tf_static"), info, {10, 2, 0})};
    EXPECT_NEAR(found.u, expected->u, 1e-9);
    EXPECT_NEAR(found.v, expected->v, 1e-9);
  }
}

TEST(Transforms, HaveTheVehicleInTheWorld) {
  FrameResult result{small_result()};
  result.world_from_vehicle = {3, -2, std::numbers::pi / 2};
  const auto message{sent_on<TFMessage>("/tf", result, {.stamp_ns = -1})};
  ASSERT_EQ(message.transforms.size(), 1u);
  const geometry_msgs::TransformStamped& one{message.transforms[0]};
  EXPECT_EQ(one.header.frame_id, "odom");
  EXPECT_EQ(one.child_frame_id, "base_link");
  EXPECT_EQ(one.header.stamp.sec, -1);
  EXPECT_EQ(one.header.stamp.nanosec, 999'999'999u);
  EXPECT_EQ(one.transform.translation.x, 3);
  EXPECT_EQ(one.transform.translation.y, -2);
  expect_near(turned(one.transform.rotation, {1, 0, 0}), {0, 1, 0});
}

TEST(Transforms, HaveALevelCamerasAxes) {
  const auto message{sent_on<TFMessage>("/tf_static", small_result())};
  ASSERT_EQ(message.transforms.size(), 1u);
  const geometry_msgs::TransformStamped& one{message.transforms[0]};
  EXPECT_EQ(one.header.frame_id, "base_link");
  EXPECT_EQ(one.child_frame_id, "stereo_left_optical");
  EXPECT_EQ(one.transform.translation.z, 1.5);
  expect_near(turned(one.transform.rotation, {0, 0, 1}), {1, 0, 0});
  expect_near(turned(one.transform.rotation, {1, 0, 0}), {0, -1, 0});
  expect_near(turned(one.transform.rotation, {0, 1, 0}), {0, 0, -1});
}

// docs/method.md §1.2: the ground lies in direction (cos pitch · sin roll, cos pitch · cos roll, sin pitch).
TEST(Transforms, HaveTheCamerasPitchAndRoll) {
  for (const double pitch : {-0.3, 0.01, 0.4}) {
    for (const double roll : {-0.2, 0.0, 0.1}) {
      Rig rig{small_rig()};
      rig.camera_pitch_rad = pitch;
      rig.camera_roll_rad = roll;
      const auto message{sent_on<TFMessage>("/tf_static", small_result(), {}, {}, rig)};
      const geometry_msgs::Quaternion& q{message.transforms.at(0).transform.rotation};
      const Vector down{std::cos(pitch) * std::sin(roll), std::cos(pitch) * std::cos(roll), std::sin(pitch)};
      expect_near(turned(q, down), {0, 0, -1});
      const Vector ahead{turned(q, {0, 0, 1})};
      EXPECT_NEAR(ahead[1], 0, 1e-12) << "the camera looks along the vehicle";
      EXPECT_GT(ahead[0], 0);
    }
  }
}

TEST(Transforms, HaveTheLevelCameraOfAPitchedOne) {
  Rig rig{small_rig()};
  rig.camera_pitch_rad = 0.2;
  const auto message{sent_on<TFMessage>("/tf_static", small_result(), {}, {}, rig)};
  ASSERT_EQ(message.transforms.size(), 2u);
  EXPECT_EQ(message.transforms[1].child_frame_id, "stereo_left_optical_level");
  expect_near(turned(message.transforms[1].transform.rotation, {0, 0, 1}), {1, 0, 0});
}

TEST(Transforms, OfTheCameraAreSentOncePerRig) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  messages.send(small_result(), {});
  messages.send(small_result(), {.stamp_ns = 1});
  EXPECT_EQ(recorder.count("/tf_static"), 1u);
  Rig found{small_rig()};
  found.camera_height_m = 2;
  messages.set_rig(found);
  messages.send(small_result(), {.stamp_ns = 2});
  EXPECT_EQ(recorder.count("/tf_static"), 2u);
  EXPECT_EQ(recorder.last<TFMessage>("/tf_static").transforms.at(0).transform.translation.z, 2);
}

TEST(Transforms, OfTheCameraWaitForSomebodyWhoWantsThem) {
  Recorder recorder;
  recorder.unwanted = {"/tf_static"};
  FrameMessages messages{recorder, small_rig()};
  messages.send(small_result(), {});
  EXPECT_EQ(recorder.count("/tf_static"), 0u);
  recorder.unwanted.clear();
  messages.send(small_result(), {.stamp_ns = 1});
  EXPECT_EQ(recorder.count("/tf_static"), 1u);
}

Odometry odometry_after(const Pose2& first, std::int64_t first_ns, const FrameResult& second, std::int64_t second_ns) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  FrameResult result{small_result()};
  result.world_from_vehicle = first;
  messages.send(result, {.stamp_ns = first_ns});
  messages.send(second, {.stamp_ns = second_ns});
  return recorder.last<Odometry>("/stereo_grid/odometry");
}

TEST(OdometryMessage, HasTheVelocityInTheVehiclesFrame) {
  FrameResult result{small_result()};
  result.world_from_vehicle = {5, 8, std::numbers::pi / 2};
  const Odometry odometry{odometry_after({5, 7, std::numbers::pi / 2}, 0, result, tenth_ns)};
  EXPECT_EQ(odometry.header.frame_id, "odom");
  EXPECT_EQ(odometry.child_frame_id, "base_link");
  EXPECT_EQ(odometry.pose.pose.position.x, 5);
  EXPECT_EQ(odometry.pose.pose.position.y, 8);
  EXPECT_NEAR(odometry.twist.twist.linear.x, 10, 1e-9);
  EXPECT_NEAR(odometry.twist.twist.linear.y, 0, 1e-9);
  EXPECT_NEAR(odometry.twist.twist.angular.z, 0, 1e-9);
}

// On a circle the vehicle drives along its own axis at each instant.
TEST(OdometryMessage, HasTheVelocityInABend) {
  const double radius_m{10};
  const double turn_rad{0.1};
  FrameResult result{small_result()};
  result.world_from_vehicle = {radius_m * std::sin(turn_rad), radius_m * (1 - std::cos(turn_rad)), turn_rad};
  const Odometry odometry{odometry_after({}, 0, result, tenth_ns)};
  EXPECT_NEAR(odometry.twist.twist.angular.z, 1, 1e-9);
  EXPECT_NEAR(odometry.twist.twist.linear.x, 10, 0.005);
  EXPECT_NEAR(odometry.twist.twist.linear.y, 0, 1e-9);
}

TEST(OdometryMessage, HasTheCovariancesOfTheOdometry) {
  const PoseCovariances covariances{{1, 2, 3, 2, 4, 5, 3, 5, 6}, {0.01, 0, 0, 0, 0.02, 0, 0, 0, 0.03}};
  const auto zeros{sent_on<Odometry>("/stereo_grid/odometry", small_result())};
  EXPECT_THAT(zeros.pose.covariance, Each(0)) << "unknown";
  EXPECT_THAT(zeros.twist.covariance, Each(0));
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  messages.send(small_result(), {.stamp_ns = 0, .covariances = covariances});
  EXPECT_EQ(recorder.last<Odometry>("/stereo_grid/odometry").twist.covariance[0], 1e6) << "no velocity yet";
  messages.send(small_result(), {.stamp_ns = tenth_ns, .covariances = covariances});
  const Odometry odometry{recorder.last<Odometry>("/stereo_grid/odometry")};
  const auto& pose{odometry.pose.covariance};
  EXPECT_THAT((std::array{pose[0], pose[1], pose[5], pose[7], pose[11], pose[35]}), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT((std::array{pose[14], pose[21], pose[28]}), Each(1e6)) << "z, roll and pitch are not measured";
  EXPECT_NEAR(odometry.twist.covariance[0], 1, 1e-9);
  EXPECT_NEAR(odometry.twist.covariance[35], 3, 1e-9);
}

TEST(OdometryMessage, HasNoVelocityWhereTheMotionIsNotKnown) {
  FrameResult result{small_result()};
  result.world_from_vehicle = {1, 0, 0};
  EXPECT_GT(odometry_after({}, 0, result, tenth_ns).twist.twist.linear.x, 0);
  EXPECT_EQ(odometry_after({}, 0, result, 0).twist.twist.linear.x, 0);
  EXPECT_EQ(odometry_after({}, 0, result, -tenth_ns).twist.twist.linear.x, 0);
  using Limits = std::numeric_limits<std::int64_t>;
  EXPECT_NEAR(odometry_after({}, Limits::min(), result, Limits::max()).twist.twist.linear.x, 0, 1e-9);
  for (const FrameStatus status : {FrameStatus::clock_gap, FrameStatus::pose_jump}) {
    result.status = {status};
    EXPECT_EQ(odometry_after({}, 0, result, tenth_ns).twist.twist.linear.x, 0);
  }
}

}  // namespace
}  // namespace stereogrid::messages::test
