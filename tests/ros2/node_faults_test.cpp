// SPDX-License-Identifier: Apache-2.0
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <utility>

#include "node_support.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid_ros::testing {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST_F(Ros2Node, SaysThatTheMountingIsNotKnownAndGoesOnOnceItIs) {
  const auto mounting{std::exchange(mounting_, std::nullopt)};
  start({});
  hand_in_infos();
  EXPECT_TRUE(wait_for([] { return !logged().empty(); }));
  EXPECT_THAT(logged(), Contains(HasSubstr("\"base_footprint\" and \"camera\" are not connected")));
  mounting_ = mounting;
  hand_in_infos();
  hand_in_frames(1);
  EXPECT_EQ(published(grids).size(), 1U);
}

TEST_F(Ros2Node, RefusesCamerasWithoutCalibrationAndTakesTheNext) {
  start({{"poses", std::string{"none"}}});
  stereogrid::Rig none{scene_.rig()};
  none.focal_px = 0;
  hand_in("left/camera_info", info_of(none, 0));
  hand_in("right/camera_info", info_of(none, 0.1));
  EXPECT_TRUE(wait_for([] { return !logged().empty(); }));
  EXPECT_THAT(logged(), Contains(HasSubstr("camera_info")));
  hand_in_infos();
  hand_in_frames(1);
  EXPECT_EQ(published(grids).size(), 1U);
}

TEST_F(Ros2Node, ReportsWhatImagesItCannotRead) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const stereogrid::StereoFrame frame{scene_.load(1)};
  sensor_msgs::msg::Image image{message_of(frame.left, begin_ns + frame.stamp_ns)};
  for (int i{0}; i < 10; ++i) {  // both sides in turn: one warning each
    image.encoding = "tiles";
    hand_in("left/image_rect", image);
    hand_in("right/image_rect", image);
  }
  EXPECT_EQ(std::ranges::count_if(logged(), [](const std::string& one) { return one.find("tiles") != one.npos; }), 2);
  image.encoding = "rgb8";
  hand_in("left/image_rect", image);
  EXPECT_THAT(logged(), Contains(HasSubstr("192×128 px, 192 bytes a row, but has 24576 bytes")));
  sensor_msgs::msg::Image left{image_of("uyvy", 192, 128, std::uint16_t{0x8040}, begin_ns + frame.stamp_ns)};
  sensor_msgs::msg::Image right{message_of(frame.right, begin_ns + frame.stamp_ns)};
  right.encoding = "bayer_grbg8";
  hand_in("left/image_rect", left);
  hand_in("right/image_rect", right);
  EXPECT_TRUE(wait_for([] { return published(grids).size() == 2; }));
}

TEST_F(Ros2Node, WarnsOnceOfCamerasThatAreSilent) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const auto silent{[] {
    return std::ranges::count_if(logged(), [](const std::string& one) { return one.starts_with("No image has come"); });
  }};
  ASSERT_TRUE(wait_for([&] { return silent() > 0; }));
  std::this_thread::sleep_for(2500ms);  // the number of seconds has changed
  EXPECT_EQ(silent(), 1) << ::testing::PrintToString(logged());
}

TEST_F(Ros2Node, StopsWhileATransformIsMissing) {
  mounting_.reset();
  start({{"transform_tolerance", 60.0}});
  hand_in_infos();
  std::this_thread::sleep_for(100ms);
  const auto begun{std::chrono::steady_clock::now()};
  node_.reset();
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 2s);
}

TEST_F(Ros2Node, LateTransformsAreWaitedForAndWarnedOfOnce) {
  std::atomic<bool> is_late{true};
  stand_in::lookup() = [&](const std::string& target, const std::string&, std::int64_t stamp_ns) {
    if (target == "base_footprint") return mounting_;
    return is_late ? std::nullopt : way(stamp_ns);
  };
  start({{"transform_tolerance", 0.02}});
  hand_in_infos();
  const auto late{[] {
    return std::ranges::count_if(logged(), [](const std::string& one) { return one.find("connected") != one.npos; });
  }};
  for (int i{0}; i < 200 && late() == 0; ++i) {
    hand_in_pair(0);
    std::this_thread::sleep_for(20ms);
  }
  for (std::size_t i{1}; i < 4; ++i) {
    hand_in_pair(i);
    std::this_thread::sleep_for(50ms);
  }
  EXPECT_EQ(late(), 1);
  is_late = false;
  hand_in_pair(4);
  EXPECT_TRUE(wait_for([] { return published(grids).size() == 1; }));
}

TEST_F(Ros2Node, ReportsAnErrorOfItsThreadAndLeavesOtherNodesAlone) {
  start({{"poses", std::string{"none"}}});
  std::atomic<int> notified{0};
  node_->set_failure_handler([&notified] { ++notified; });
  hand_in_infos();
  stand_in::world().publishing_fails = true;
  EXPECT_TRUE(wait_for([&] {
    hand_in_pair(0);
    return node_->has_failed();
  }));
  EXPECT_TRUE(wait_for([&] { return notified == 1; }));
  EXPECT_THAT(logged(), Contains(HasSubstr("stopped: failed to publish message")));
  {
    const std::scoped_lock lock{stand_in::world().mutex};
    EXPECT_FALSE(stand_in::world().is_shut_down);
  }
  stand_in::world().publishing_fails = false;
  EXPECT_EQ(node_->deactivate().id(), 2);
  EXPECT_EQ(node_->activate().id(), 3);
  EXPECT_FALSE(node_->has_failed());
}

TEST(Ros2Process, WrongParametersAreExitCode1AndOneSentence) {
  FILE* const pipe{popen(STEREOGRID_ROS_STAND_IN " -p poses:=gps 2>&1", "re")};
  std::array<char, 1000> text{};
  const std::size_t size{std::fread(text.data(), 1, text.size() - 1, pipe)};
  const int status{pclose(pipe)};
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_STREQ(text.data(), "stereo_grid: parameter poses: gps (allowed tf, images, none).\n");
  EXPECT_EQ(size, std::string{text.data()}.size());
  EXPECT_EQ(std::system(STEREOGRID_ROS_STAND_IN " -p poses:=none"), 0);
}

template <class T>
sensor_msgs::msg::CompressedImage png_of(const stereogrid::Image<T>& image, const char* format, std::size_t head_bytes,
                                         std::int64_t stamp_ns) {
  const std::string path{::testing::TempDir() + "node_test.png"};
  stereogrid::io::write_png(path, image);
  std::ifstream file{path, std::ios::binary};
  sensor_msgs::msg::CompressedImage message{header_of(stamp_ns), format, std::vector<std::uint8_t>(head_bytes)};
  message.data.insert(message.data.end(), std::istreambuf_iterator<char>{file}, {});
  return message;
}

/// Disparities of 16 px as each kind of message.
TEST_F(Ros2Node, TakesDepthAndDisparities) {
  const stereogrid::Rig rig{scene_.rig()};
  constexpr float disparity_px{16};
  const double baseline_m{0.25};
  const auto depth_m{static_cast<float>(rig.focal_px * baseline_m / disparity_px)};
  const auto depth_mm{static_cast<std::uint16_t>(std::lround(1000 * depth_m))};
  const auto send{[&](const std::string& kind, std::int64_t at_ns) {
    const auto left{scene_.load(0).left};
    const int w{rig.width_px};
    const int h{rig.height_px};
    if (kind == "compressedDepth") {
      hand_in("left/image_rect/compressed", png_of(left, "mono8; png compressed", 0, at_ns));
      return hand_in("depth/image_rect/compressedDepth",
                     png_of(stereogrid::Image<std::uint16_t>(w, h, depth_mm), "16UC1; compressedDepth png", 12, at_ns));
    }
    hand_in("left/image_rect", message_of(left, at_ns));
    if (kind == "disparity") {
      hand_in("disparity",
              stereo_msgs::msg::DisparityImage{header_of(at_ns), image_of("32FC1", w, h, disparity_px, at_ns),
                                               static_cast<float>(rig.focal_px), static_cast<float>(baseline_m)});
    } else if (kind == "half of the size") {
      hand_in("depth/image_rect", image_of("16UC1", w / 2, h / 2, depth_mm, at_ns));
    } else {
      hand_in("depth/image_rect", image_of("32FC1", w, h, depth_m, at_ns));
    }
  }};
  for (const std::string kind : {"32FC1", "half of the size", "compressedDepth", "disparity"}) {
    node_.reset();
    stand_in::world().published.clear();
    const bool is_compressed{kind == "compressedDepth"};
    start({{"poses", std::string{"none"}},
           {"input", std::string{kind == "disparity" ? "disparity" : "depth"}},
           {"image_transport", std::string{is_compressed ? "compressed" : "raw"}},
           {"depth_image_transport", std::string{is_compressed ? "compressedDepth" : "raw"}}});
    hand_in("left/camera_info", info_of(rig, 0));
    for (int attempt{0}; attempt < 100 && published(grids).empty(); ++attempt) {
      send(kind, begin_ns + attempt * second_ns / 10);
      wait_for_grid(0);
    }
    ASSERT_FALSE(published(grids).empty()) << kind << ::testing::PrintToString(logged());
    EXPECT_TRUE(wait_for([] { return !published("/stereo_grid/points").empty(); }));
    stereogrid::messages::sensor_msgs::PointCloud2 points;
    stereogrid::messages::decode(std::as_bytes(std::span{published("/stereo_grid/points").front()}), points);
    ASSERT_GT(points.data.size(), 0U);
    float x_m{0};
    std::memcpy(&x_m, points.data.data(), sizeof x_m);
    EXPECT_NEAR(x_m, depth_m, 0.01F * depth_m) << kind;
  }
}

TEST_F(Ros2Node, RefusesDepthOfAnotherShape) {
  start({{"poses", std::string{"none"}}, {"input", std::string{"depth"}}});
  const stereogrid::Rig rig{scene_.rig()};
  hand_in("left/camera_info", info_of(rig, 0));
  EXPECT_TRUE(wait_for([&] {
    hand_in("depth/image_rect", image_of("32FC1", rig.width_px / 2, rig.height_px, 2.0F, begin_ns));
    return !logged().empty();
  }));
  EXPECT_THAT(logged(), ElementsAre(HasSubstr("depth has 96×128 px, but the images have 192×128")));
}

}  // namespace
}  // namespace stereogrid_ros::testing
