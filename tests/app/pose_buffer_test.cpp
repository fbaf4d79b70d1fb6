// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ros2/transform_buffer.hpp"

#include <gmock/gmock.h>

#include <thread>

#include "stereogrid/error.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr std::int64_t ms{1'000'000};

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

}  // namespace
}  // namespace stereogrid::app
