// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "node_support.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid_ros::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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
