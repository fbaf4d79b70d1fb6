// SPDX-License-Identifier: Apache-2.0
#include "live/live.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <future>
#include <limits>
#include <stdexcept>

#include <cmath>
#include <numbers>
#include <thread>
#include "frame_stages.hpp"
#include "ros2/ros2_source.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/rosbag/transforms.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid::app::testing {
namespace {

using namespace std::chrono_literals;
using capture::Drop;
using capture::LiveFrame;

constexpr Rig rig{.width_px = 64, .height_px = 48, .focal_px = 50, .cx_px = 32, .cy_px = 24, .baseline_m = 0.1};

LiveFrame frame(int index, bool resets_before = false, int width = rig.width_px) {
  LiveFrame live;
  live.frame.index = index;
  live.frame.stamp_ns = index * std::int64_t{33'000'000};
  live.frame.left = live.frame.right = Image<std::uint8_t>(width, rig.height_px);
  live.captured = capture::Clock::now();
  live.resets_before = resets_before;
  return live;
}

/// Gives a list of frames as fast as they are taken, and says when all are.
class ListedFrames final : public capture::LiveSource {
 public:
  explicit ListedFrames(std::deque<LiveFrame> frames, bool breaks = false)
      : frames_{std::move(frames)}, breaks_{breaks} {}

  [[nodiscard]] const Rig& rig() const override { return testing::rig; }
  [[nodiscard]] std::optional<LiveFrame> next(std::chrono::milliseconds) override {
    if (taken_ >= held_after_) {
      std::this_thread::sleep_for(1ms);
      return std::nullopt;
    }
    ++taken_;
    if (frames_.empty()) {
      given_.set_value();
      has_ended_ = true;
      if (breaks_) throw std::runtime_error{"the camera burns"};
      return std::nullopt;
    }
    LiveFrame first{std::move(frames_.front())};
    frames_.pop_front();
    if (first.frame.left.empty()) throw InputError{"a torn image"};
    return first;
  }
  [[nodiscard]] bool has_ended() const override { return has_ended_; }
  [[nodiscard]] std::string fault() const override { return ""; }
  [[nodiscard]] std::vector<Drop> dropped() const override { return {{"torn", 1}}; }

  void wait() { given_.get_future().wait(); }
  /// Holds back further frames after this number, of all.
  void hold_after(int frames) { held_after_ = frames; }

 private:
  std::deque<LiveFrame> frames_;
  bool breaks_;
  int taken_{0};
  std::atomic<int> held_after_{std::numeric_limits<int>::max()};
  std::atomic<bool> has_ended_{false};
  std::promise<void> given_;
};

/// The input, and the source once more.
struct Listed {
  explicit Listed(std::deque<LiveFrame> frames, PoseSource poses, bool breaks = false) {
    auto made{std::make_unique<ListedFrames>(std::move(frames), breaks)};
    source = made.get();
    input.source = std::move(made);
    input.poses = poses;
  }
  LiveInput input;
  ListedFrames* source{nullptr};
};

std::map<std::string, std::int64_t> counts(const PlacedFrames& frames) {
  std::map<std::string, std::int64_t> counted;
  for (const Drop& drop : frames.dropped()) counted[drop.reason] = drop.frames;
  return counted;
}

TEST(PlacedFrames, TheNewestWaitsAndReportsWhatAnEarlierOneBegan) {
  Listed listed{{frame(0), frame(1), frame(2, true), frame(3)}, PoseSource::odometry};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  const std::optional<capture::PreparedFrame> last{frames.next(1s)};
  ASSERT_TRUE(last);
  EXPECT_EQ(last->frame.index, 3);
  EXPECT_TRUE(last->resets_before);  // frame 2 does, which was dropped
  EXPECT_TRUE(last->odometry_ms);
  EXPECT_TRUE(last->frame.world_from_vehicle);
  EXPECT_EQ(counts(frames)["the pipeline was busy"], 3);
  EXPECT_FALSE(frames.next(1s));
  EXPECT_TRUE(frames.has_ended());
}

TEST(PlacedFrames, RestartsOnRequest) {
  Listed listed{{frame(0), frame(1)}, PoseSource::none};
  listed.source->hold_after(1);
  PlacedFrames frames{listed.input};
  const std::optional<capture::PreparedFrame> before{frames.next(1s)};
  frames.request_reset();
  listed.source->hold_after(2);
  const std::optional<capture::PreparedFrame> after{frames.next(1s)};
  ASSERT_TRUE(before && after);
  EXPECT_TRUE(after->resets_before);
  EXPECT_FALSE(after->odometry_ms);
  EXPECT_FALSE(after->frame.world_from_vehicle);
}

TEST(PlacedFrames, CountsWhatCannotBeUsedAndGoesOn) {
  Listed listed{{LiveFrame{}, frame(1, false, 80), frame(2)}, PoseSource::odometry};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  const std::optional<capture::PreparedFrame> last{frames.next(1s)};
  ASSERT_TRUE(last);
  EXPECT_EQ(last->frame.index, 2);
  EXPECT_EQ(counts(frames), (std::map<std::string, std::int64_t>{{"torn", 1}, {"do not fit the odometry", 1}}));
}

TEST(PlacedFrames, AFailureComesAfterTheLastFrame) {
  Listed listed{{frame(0)}, PoseSource::odometry, true};
  PlacedFrames frames{listed.input};
  listed.source->wait();
  EXPECT_TRUE(frames.next(1s));
  EXPECT_FALSE(frames.has_ended());
  EXPECT_THROW((void)frames.next(1s), std::runtime_error);
  EXPECT_TRUE(frames.has_ended());
}

using messages::geometry_msgs::TransformStamped;
using rosbag::TransformBuffer;
using ::testing::HasSubstr, ::testing::ThrowsMessage;

constexpr std::int64_t ms{1'000'000};

TransformStamped transform(const std::string& parent, const std::string& child, std::int64_t stamp_ms, double x_m,
                           double yaw_rad = 0) {
  TransformStamped one;
  one.header.stamp = {static_cast<std::int32_t>(stamp_ms / 1000), static_cast<std::uint32_t>(stamp_ms % 1000 * ms)};
  one.header.frame_id = parent;
  one.child_frame_id = child;
  one.transform.translation.x = x_m;
  one.transform.rotation.z = std::sin(yaw_rad / 2);
  one.transform.rotation.w = std::cos(yaw_rad / 2);
  return one;
}

/// x right of the camera is −y of the vehicle, y down is −z, z ahead is x.
TransformStamped mount(double height_m) {
  TransformStamped one{transform("camera_link", "optical", 0, 0)};
  one.transform.translation.z = height_m;
  one.transform.rotation = {-0.5, 0.5, -0.5, 0.5};
  return one;
}

TEST(TransformBuffer, FollowsChainsAndInterpolates) {
  TransformBuffer buffer;
  buffer.add({{transform("base_link", "camera_link", 0, 0.4), mount(1.2)}}, true);
  buffer.add({{transform("map", "odom", 0, 100), transform("odom", "/base_link", 1000, 2)}}, false);
  buffer.add({{transform("map", "odom", 5000, 100), transform("odom", "base_link", 2000, 4, std::numbers::pi / 2)}},
             false);
  const cv::Affine3d half{buffer.at("map", "optical", 1500 * ms, 0ms)};
  const double diagonal{0.4 / std::numbers::sqrt2};
  EXPECT_NEAR(half.matrix(0, 3), 103 + diagonal, 1e-9);
  EXPECT_NEAR(half.matrix(1, 3), diagonal, 1e-9);
  EXPECT_NEAR(half.matrix(2, 3), 1.2, 1e-9);
  EXPECT_NEAR(rosbag::pose_of_camera(half).yaw_rad, std::numbers::pi / 4, 1e-9);
  EXPECT_NEAR(rosbag::pose_of_vehicle(buffer.at("map", "base_link", 2000 * ms, 0ms)).yaw_rad, std::numbers::pi / 2,
              1e-9);
  // the other way round, and between branches
  EXPECT_NEAR(buffer.at("base_link", "odom", 1000 * ms, 0ms).matrix(0, 3), -2, 1e-9);
  EXPECT_NEAR(buffer.newest("odom", "map", 0ms).matrix(0, 3), -100, 1e-9);
  EXPECT_NEAR(buffer.at("optical", "optical", 0, 0ms).matrix(0, 0), 1, 1e-9);
}

TEST(TransformBuffer, RefusesToExtrapolate) {
  TransformBuffer buffer;
  const auto at = [&](std::int64_t stamp_ms) {
    return [&buffer, stamp_ms] { (void)buffer.at("odom", "base_link", stamp_ms * ms, 20ms); };
  };
  EXPECT_THAT(at(0), ThrowsMessage<InputError>(HasSubstr("odom and base_link are not connected")));
  buffer.add({{transform("odom", "base_link", 1000, 0), transform("odom", "base_link", 1100, 1)}}, false);
  EXPECT_THAT(at(1110), ThrowsMessage<InputError>(HasSubstr("odom → base_link ends before the image")));
  const auto begun{std::chrono::steady_clock::now()};
  EXPECT_THAT([&] { (void)buffer.at("odom", "base_link", 900 * ms, 10s); },
              ThrowsMessage<InputError>(HasSubstr("begins after the image")));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 5s) << "what is over does not come";
}

TEST(TransformBuffer, WaitsForWhatIsLate) {
  TransformBuffer buffer;
  buffer.add({{transform("odom", "base_link", 1000, 0)}}, false);
  std::jthread late{[&] {
    std::this_thread::sleep_for(30ms);
    buffer.add({{transform("odom", "base_link", 1100, 1)}}, false);
  }};
  EXPECT_NEAR(buffer.at("odom", "base_link", 1050 * ms, 20s).matrix(0, 3), 0.5, 1e-9);
}

TEST(TransformBuffer, KeepsTenSecondsAndStaticTransforms) {
  TransformBuffer buffer;
  buffer.add({{transform("base_link", "camera", 0, 1)}}, true);
  for (int i{0}; i < 400; ++i) buffer.add({{transform("odom", "base_link", 100 * i, i)}}, false);
  EXPECT_NEAR(buffer.at("odom", "camera", 35'050 * ms, 0ms).matrix(0, 3), 351.5, 1e-9);
  EXPECT_THROW(static_cast<void>(buffer.at("odom", "camera", 10'000 * ms, 0ms)), InputError);
  buffer.add({{transform("odom", "base_link", 1000, 7)}}, false);  // a simulation begins again
  EXPECT_NEAR(buffer.at("odom", "camera", 1000 * ms, 0ms).matrix(0, 3), 8, 1e-9);
  buffer.clear();
  EXPECT_THROW(static_cast<void>(buffer.newest("odom", "camera", 0ms)), InputError);
  EXPECT_NEAR(buffer.newest("base_link", "camera", 0ms).matrix(0, 3), 1, 1e-9);
}

TEST(TransformBuffer, DropsWhatIsNoTransform) {
  TransformBuffer buffer;
  TransformStamped half{transform("odom", "base_link", 0, 0)};
  half.transform.rotation.w = 0.5;
  buffer.add({{half, transform("odom", "odom", 0, 0),
               transform("odom", "base_link", 0, std::numeric_limits<double>::infinity())}},
             false);
  EXPECT_THROW(static_cast<void>(buffer.newest("odom", "base_link", 0ms)), InputError);
  // a loop ends
  buffer.add({{transform("a", "b", 0, 0), transform("b", "a", 0, 0)}}, false);
  EXPECT_THROW(static_cast<void>(buffer.newest("odom", "a", 0ms)), InputError);
}

TEST(TransformBuffer, GivesExtrinsics) {
  TransformBuffer buffer;
  TransformStamped pitched{transform("base_footprint", "camera_link", 0, 0.3)};
  pitched.transform.rotation = {0, std::sin(0.05), 0, std::cos(0.05)};  // 0.1 rad down
  buffer.add({{pitched, mount(0.8)}}, true);
  Rig placed;
  ASSERT_TRUE(rosbag::set_extrinsics(placed, buffer.newest("base_footprint", "optical", 0ms)));
  EXPECT_NEAR(placed.camera_height_m, 0.8 * std::cos(0.1), 1e-9);
  EXPECT_NEAR(placed.camera_pitch_rad, 0.1, 1e-9);
  EXPECT_NEAR(placed.camera_roll_rad, 0, 1e-9);
  EXPECT_FALSE(rosbag::set_extrinsics(placed, cv::Affine3d{})) << "looks up";
}

TEST(TransformBuffer, PlacesACameraInTheRobot) {
  TransformBuffer buffer;
  TransformStamped left{transform("base_link", "camera_link", 0, -0.2)};  // heading to the left, 0.1 rad down
  left.transform.translation.y = 0.3;
  const double turned{std::numbers::sqrt2 / 2};
  left.transform.rotation = {-turned * std::sin(0.05), turned * std::sin(0.05), turned * std::cos(0.05),
                             turned * std::cos(0.05)};
  TransformStamped optical{mount(0)};
  buffer.add({{left, optical}}, true);
  io::Calibration calibration;
  EXPECT_THAT(rosbag::place_camera(calibration, buffer, "base_link", "optical", "/left"),
              HasSubstr("not above the road"))
      << "of base_link, which is as high";
  EXPECT_NEAR(calibration.rig.camera_x_m, -0.2, 1e-9);
  EXPECT_NEAR(calibration.rig.camera_y_m, 0.3, 1e-9);
  EXPECT_NEAR(calibration.rig.camera_yaw_rad, std::numbers::pi / 2, 1e-9);
  EXPECT_FALSE(calibration.has_extrinsics);
  left.transform.translation.z = 0.5;
  buffer.add({{left}}, true);
  EXPECT_THAT(rosbag::place_camera(calibration, buffer, "base_link", "optical", "/left"),
              HasSubstr("0.50 m above base_link (checked against the road)"));
  EXPECT_FALSE(calibration.has_extrinsics) << "base_link may be above the road";
  TransformStamped base{transform("base_footprint", "base_link", 0, 0)};
  base.transform.translation.z = 0.4;
  buffer.add({{base}}, true);
  EXPECT_THAT(rosbag::place_camera(calibration, buffer, "base_link", "optical", "/left"),
              HasSubstr("-0.20 m ahead, 0.30 m and 90.0° to the left in base_link, 0.90 m above base_footprint"));
  EXPECT_TRUE(calibration.has_extrinsics);
  EXPECT_NEAR(calibration.rig.camera_height_m, 0.9, 1e-9);
  EXPECT_NEAR(calibration.rig.camera_pitch_rad, 0.1, 1e-9);
  EXPECT_NEAR(calibration.rig.camera_roll_rad, 0, 1e-9);
  EXPECT_THAT([&] { (void)rosbag::place_camera(calibration, buffer, "base_link", "rear", "/rear/image"); },
              ThrowsMessage<InputError>(HasSubstr("/rear/image: /tf_static does not connect base_link with 'rear'")));
}

/// Along x, a metre each 100 ms.
io::StampedPose pose_at(std::int64_t stamp_ms) {
  return {stamp_ms * ms, {static_cast<double>(stamp_ms) / 100, 0, 0}};
}

TEST(PoseBuffer, GivesThePoseBetweenItsNeighbours) {
  PoseBuffer buffer{"/odom"};
  buffer.add({pose_at(0), pose_at(100), pose_at(200)});
  EXPECT_DOUBLE_EQ(buffer.at(0, 0ms).x_m, 0);
  EXPECT_DOUBLE_EQ(buffer.at(130 * ms, 0ms).x_m, 1.3);
  EXPECT_DOUBLE_EQ(buffer.at(200 * ms, 0ms).x_m, 2);
  EXPECT_DOUBLE_EQ(buffer.at(280 * ms, 0ms).x_m, 2.8);  // continued motion
}

TEST(PoseBuffer, SaysWhyThereIsNone) {
  PoseBuffer buffer{"/odom"};
  const auto at = [&](std::int64_t stamp_ms) { return [&buffer, stamp_ms] { (void)buffer.at(stamp_ms * ms, 0ms); }; };
  EXPECT_THAT(at(0), ThrowsMessage<InputError>(HasSubstr("/odom: there is no pose yet")));
  buffer.add({pose_at(1000), pose_at(1100), pose_at(4000)});
  EXPECT_THAT(at(900), ThrowsMessage<InputError>(HasSubstr("no pose of the image's instant")));
  EXPECT_THAT(at(2000), ThrowsMessage<InputError>(HasSubstr("no pose of the image's instant")));  // in a gap
  buffer.add({pose_at(4100)});
  EXPECT_THAT(at(4300), ThrowsMessage<InputError>(HasSubstr("behind the images")));
}

TEST(PoseBuffer, WaitsForThePoseBehindTheImage) {
  PoseBuffer buffer{"/odom"};
  buffer.add({pose_at(0), pose_at(100)});
  std::jthread later{[&] {
    std::this_thread::sleep_for(50ms);
    buffer.add({{200 * ms, {5, 0, 0}}});
  }};
  EXPECT_DOUBLE_EQ(buffer.at(150 * ms, 10s).x_m, 3);  // not 1.5, which it would be without the third
}

/// The first image may have the stamp of the first pose.
TEST(PoseBuffer, WaitsForASecondPose) {
  PoseBuffer buffer{"/odom"};
  std::jthread later{[&] {
    std::this_thread::sleep_for(20ms);
    buffer.add({pose_at(100)});
    std::this_thread::sleep_for(50ms);
    buffer.add({pose_at(200)});
  }};
  buffer.wait_for_first(10s);
  EXPECT_DOUBLE_EQ(buffer.at(100 * ms, 10s).x_m, 1);
}

TEST(PoseBuffer, DropsWhatCameBeforeTheStampsStepBack) {
  PoseBuffer buffer{"/odom"};
  buffer.add({pose_at(5000), pose_at(5100)});
  buffer.add({pose_at(100)});
  EXPECT_THAT([&] { (void)buffer.at(100 * ms, 0ms); }, ThrowsMessage<InputError>(HasSubstr("no pose yet")));
  buffer.add({pose_at(200), pose_at(200), pose_at(300)});
  EXPECT_DOUBLE_EQ(buffer.at(250 * ms, 0ms).x_m, 2.5);
}

TEST(PoseBuffer, KeepsTheLastSeconds) {
  PoseBuffer buffer{"/odom"};
  for (std::int64_t i{0}; i < 10'000; ++i) buffer.add({pose_at(i)});
  EXPECT_DOUBLE_EQ(buffer.at(9'000 * ms, 0ms).x_m, 90);
  EXPECT_THAT([&] { (void)buffer.at(5'000 * ms, 0ms); }, ThrowsMessage<InputError>(HasSubstr("instant")));
}

TEST(PoseStage, CovariancesAreThoseOfTheVehicle) {
  const scenes::Scene street{scenes::parse_scene("scene:street?frames=3&width=256&height=160")};
  const auto covariance_of_motion = [&](double camera_y_m, double camera_yaw_rad) {
    Rig placed{street.rig()};
    placed.camera_y_m = camera_y_m;
    placed.camera_yaw_rad = camera_yaw_rad;
    PoseStage stage{PoseSource::odometry, placed, {}};
    PoseStage::Placed last;
    for (std::size_t i{0}; i < street.size(); ++i) {
      StereoFrame frame{street.load(i)};
      last = stage.place(frame);
    }
    return last.covariances.value().motion;
  };
  const auto ahead{covariance_of_motion(0, 0)};
  const auto aside{covariance_of_motion(0, std::numbers::pi / 2)};
  EXPECT_NE(ahead[0], ahead[4]);
  EXPECT_NEAR(aside[0], ahead[4], 1e-12);
  EXPECT_NEAR(aside[4], ahead[0], 1e-12);
  const auto moved{covariance_of_motion(2, 0)};
  EXPECT_GT(ahead[8], 0);
  EXPECT_NEAR(moved[0], ahead[0] + 4 * ahead[2] + 4 * ahead[8], 1e-12) << "a turn of the vehicle moves the camera";
}

}  // namespace
}  // namespace stereogrid::app::testing
