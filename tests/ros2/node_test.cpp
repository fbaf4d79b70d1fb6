// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The component of ROS 2 against stand-ins of rclcpp and tf2_ros: what it does with messages, not how they come.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "stereo_grid_node.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/tf2_msgs.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "translate.hpp"

namespace stereogrid_ros::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::int64_t second_ns{1'000'000'000};
constexpr std::int64_t begin_ns{1'700'000'000 * second_ns};

std_msgs::msg::Header header_of(std::int64_t stamp_ns) {
  return {{static_cast<std::int32_t>(stamp_ns / second_ns), static_cast<std::uint32_t>(stamp_ns % second_ns)},
          "camera"};
}

sensor_msgs::msg::Image message_of(const stereogrid::Image<std::uint8_t>& image, std::int64_t stamp_ns) {
  sensor_msgs::msg::Image message;
  message.header = header_of(stamp_ns);
  message.width = static_cast<std::uint32_t>(image.width());
  message.height = static_cast<std::uint32_t>(image.height());
  message.step = message.width;
  message.encoding = "mono8";
  message.data.assign(image.data(), image.data() + image.width() * image.height());
  return message;
}

sensor_msgs::msg::CameraInfo info_of(const stereogrid::Rig& rig, double baseline_m) {
  sensor_msgs::msg::CameraInfo info;
  info.header = header_of(begin_ns);
  info.width = static_cast<std::uint32_t>(rig.width_px);
  info.height = static_cast<std::uint32_t>(rig.height_px);
  info.distortion_model = "plumb_bob";
  info.d.resize(5);
  info.k = {rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, rig.cy_px, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {rig.focal_px, 0, rig.cx_px, -rig.focal_px * baseline_m, 0, rig.focal_px, rig.cy_px, 0, 0, 0, 1, 0};
  return info;
}

template <class Message>
void hand_in(const std::string& topic, const Message& message) {
  std::function<void(const void*)> subscriber;
  {
    const std::scoped_lock lock{stand_in::world().mutex};
    subscriber = stand_in::world().subscribers.at(topic);
  }
  subscriber(&message);
}

std::vector<std::vector<std::uint8_t>> published(const std::string& topic) {
  const std::scoped_lock lock{stand_in::world().mutex};
  return stand_in::world().published[topic].messages;
}

std::vector<std::string> told() {
  const std::scoped_lock lock{stand_in::world().mutex};
  return stand_in::world().log;
}

/// Until it is so, or half a minute has passed.
template <class Condition>
bool wait_for(Condition condition) {
  for (const auto end{std::chrono::steady_clock::now() + 30s}; std::chrono::steady_clock::now() < end;) {
    if (condition()) return true;
    std::this_thread::sleep_for(2ms);
  }
  return condition();
}

/// Keeps what a pipeline of ours sends, by topic.
class Kept final : public stereogrid::messages::Sink {
 public:
  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    topics_.push_back(channel.topic);
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    const auto* const bytes{reinterpret_cast<const std::uint8_t*>(cdr.data())};
    messages[topics_.at(channel)].emplace_back(bytes, bytes + cdr.size());
  }

  std::map<std::string, std::vector<std::vector<std::uint8_t>>> messages;

 private:
  std::vector<std::string> topics_;
};

class Ros2Node : public ::testing::Test {
 protected:
  void SetUp() override {
    stand_in::World& world{stand_in::world()};
    world.published.clear();
    world.subscribers.clear();
    world.missing_packages.clear();
    world.log.clear();
    world.is_shut_down = false;
    world.publishing_fails = false;
    stand_in::lookup() = [this](const std::string& target, const std::string&, std::int64_t stamp_ns) {
      return target == "base_footprint" ? mounting_ : way(stamp_ns);
    };
  }

  void start(std::vector<rclcpp::Parameter> parameters) {
    parameters.emplace_back("device", std::string{"cpu"});
    node_.emplace(rclcpp::NodeOptions{}.parameter_overrides(parameters));
  }
  /// As the node reads it, whose baseline is a quotient.
  [[nodiscard]] stereogrid::Rig read_rig() const {
    const auto camera{[&](double baseline_m) { return camera_of(info_of(scene_.rig(), baseline_m), "camera"); }};
    stereogrid::Rig rig{stereogrid::io::ros_calibration(camera(0), camera(scene_.rig().baseline_m), true).rig};
    set_extrinsics(rig, *mounting_);
    return rig;
  }
  void hand_in_infos() {
    hand_in("left/camera_info", info_of(scene_.rig(), 0));
    hand_in("right/camera_info", info_of(scene_.rig(), scene_.rig().baseline_m));
  }
  /// Publishes frames repeatedly until the first grid: another thread opens the pair, and earlier images are dropped.
  void hand_in_frames(std::size_t count) {
    for (std::size_t i{0}; i < count; ++i) {
      const std::size_t before{published(grids).size()};
      for (int attempt{0}; attempt < 100 && published(grids).size() == before; ++attempt) {
        hand_in_pair(i);
        if (wait_for_grid(before)) break;
      }
    }
  }
  void hand_in_pair(std::size_t i) {
    const stereogrid::StereoFrame frame{scene_.load(i)};
    hand_in("left/image_rect", message_of(frame.left, begin_ns + frame.stamp_ns));
    hand_in("right/image_rect", message_of(frame.right, begin_ns + frame.stamp_ns));
  }
  static bool wait_for_grid(std::size_t before) {
    for (int i{0}; i < 200; ++i) {
      if (published(grids).size() > before) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }

  [[nodiscard]] static std::optional<geometry_msgs::msg::Transform> way(std::int64_t stamp_ns) {
    const double x_m{static_cast<double>(stamp_ns - begin_ns) / 1e9};  // 1 m/s ahead
    return geometry_msgs::msg::Transform{{x_m, 5, 1}, {-0.5, 0.5, -0.5, 0.5}};
  }

  static constexpr const char* grids{"/stereo_grid/occupancy_grid"};
  stereogrid::scenes::Scene scene_{stereogrid::scenes::parse_scene("scene:street?width=192&height=128&frames=6")};
  // level: z ahead becomes x, x to the right becomes −y
  std::optional<geometry_msgs::msg::Transform> mounting_{
      geometry_msgs::msg::Transform{{0.5, 0, scene_.rig().camera_height_m}, {-0.5, 0.5, -0.5, 0.5}}};
  std::optional<StereoGridNode> node_;
};

TEST_F(Ros2Node, SendsWhatThePipelineSends) {
  Kept kept;
  stereogrid::Pipeline pipeline{stereogrid::Config{}, read_rig()};
  stereogrid::messages::FrameMessages messages{
      kept, read_rig(), {.vehicle_frame = "stereo_grid", .camera_frame = "stereo_grid_left_optical"}};
  for (std::size_t i{0}; i < scene_.size(); ++i) {
    stereogrid::StereoFrame frame{scene_.load(i)};
    frame.stamp_ns += begin_ns;
    frame.world_from_vehicle.reset();
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns});
  }

  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(scene_.size());
  for (const char* topic : {"occupancy_grid", "observed_grid", "grid_map", "scan", "obstacles", "points"}) {
    const std::string name{std::string{"/stereo_grid/"} + topic};
    ASSERT_EQ(kept.messages[name].size(), scene_.size()) << topic;
    EXPECT_TRUE(wait_for([&] { return published(name).size() == scene_.size(); })) << topic;
    EXPECT_TRUE(published(name) == kept.messages[name]) << topic;
  }
  const std::scoped_lock lock{stand_in::world().mutex};
  EXPECT_TRUE(stand_in::world().published[grids].latched);
  EXPECT_FALSE(stand_in::world().published["/stereo_grid/scan"].latched);
  EXPECT_EQ(stand_in::world().published[grids].type, "nav_msgs/msg/OccupancyGrid");
}

TEST_F(Ros2Node, FollowsTf) {
  Kept kept;
  stereogrid::Pipeline pipeline{stereogrid::Config{}, read_rig(), {.start = {0, 5, 0}}};
  stereogrid::messages::FrameMessages messages{kept, read_rig(), {.topics = {"occupancy_grid"}}};
  for (std::size_t i{0}; i < 3; ++i) {
    stereogrid::StereoFrame frame{scene_.load(i)};
    frame.stamp_ns += begin_ns;
    frame.world_from_vehicle = stereogrid::Pose2{static_cast<double>(frame.stamp_ns - begin_ns) / 1e9, 5, 0};
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns});
  }

  start({});
  hand_in_infos();
  hand_in_frames(3);
  EXPECT_TRUE(published(grids) == kept.messages[grids]);
  ASSERT_TRUE(wait_for([] { return published("/tf").size() == 3; }));
  stereogrid::messages::tf2_msgs::TFMessage tf;
  stereogrid::messages::decode(std::as_bytes(std::span{published("/tf").back()}), tf);
  ASSERT_EQ(tf.transforms.size(), 1U);
  const auto& last{tf.transforms[0]};
  EXPECT_EQ(last.header.frame_id, "odom");
  EXPECT_EQ(last.child_frame_id, "stereo_grid");
  EXPECT_NEAR(last.transform.translation.x, static_cast<double>(scene_.load(2).stamp_ns) / 1e9, 1e-6);
  EXPECT_NEAR(last.transform.translation.y, 5, 1e-9);
}

TEST_F(Ros2Node, PublishesWhileActiveOnly) {
  start({{"autostart", false}, {"poses", std::string{"none"}}});
  const auto has_subscriptions{[] {
    const std::scoped_lock lock{stand_in::world().mutex};
    return !stand_in::world().subscribers.empty();
  }};
  EXPECT_EQ(node_->activate().id(), 1);  // unconfigured: refused
  EXPECT_EQ(node_->configure().id(), 2);
  EXPECT_FALSE(has_subscriptions());
  for (int round{0}; round < 2; ++round) {
    EXPECT_EQ(node_->activate().id(), 3);
    hand_in_infos();
    hand_in_frames(2);
    EXPECT_EQ(published(grids).size(), 2U) << round;
    EXPECT_EQ(node_->deactivate().id(), 2);
    EXPECT_FALSE(has_subscriptions());
  }
  EXPECT_EQ(node_->cleanup().id(), 1);
  EXPECT_EQ(node_->configure().id(), 2);
  EXPECT_EQ(node_->activate().id(), 3);
  EXPECT_EQ(node_->shutdown().id(), 4);
  EXPECT_FALSE(has_subscriptions());
}

/// Image of one value everywhere.
template <class T>
sensor_msgs::msg::Image image_of(const char* encoding, int width_px, int height_px, T value, std::int64_t stamp_ns) {
  sensor_msgs::msg::Image image{message_of(stereogrid::Image<std::uint8_t>(width_px, height_px), stamp_ns)};
  const std::vector<T> all(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), value);
  image.encoding = encoding;
  image.step = image.width * sizeof(T);
  image.data.resize(all.size() * sizeof(T));
  std::memcpy(image.data.data(), all.data(), image.data.size());
  return image;
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
    ASSERT_FALSE(published(grids).empty()) << kind << ::testing::PrintToString(told());
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
    return !told().empty();
  }));
  EXPECT_THAT(told(), ElementsAre(HasSubstr("depth has 96×128 px, but the images have 192×128")));
}

TEST_F(Ros2Node, SaysThatTheMountingIsNotKnownAndGoesOnOnceItIs) {
  const auto mounting{std::exchange(mounting_, std::nullopt)};
  start({});
  hand_in_infos();
  EXPECT_TRUE(wait_for([] { return !told().empty(); }));
  EXPECT_THAT(told(), Contains(HasSubstr("\"base_footprint\" and \"camera\" are not connected")));
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
  EXPECT_TRUE(wait_for([] { return !told().empty(); }));
  EXPECT_THAT(told(), Contains(HasSubstr("camera_info")));
  hand_in_infos();
  hand_in_frames(1);
  EXPECT_EQ(published(grids).size(), 1U);
}

TEST_F(Ros2Node, LeavesTopicsOutWhosePackagesAreMissing) {
  stand_in::world().missing_packages = {"nav2_dynamic_msgs", "foxglove_msgs"};
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const auto left_out{Contains(HasSubstr("/stereo_grid/obstacles is not published: package 'nav2_dynamic_msgs'"))};
  EXPECT_TRUE(wait_for([&] { return ::testing::Matches(left_out)(told()); }));
  EXPECT_TRUE(wait_for([] { return published("/stereo_grid/observed_grid").size() == 1; }));
  EXPECT_THAT(published("/stereo_grid/obstacles"), IsEmpty());
}

TEST_F(Ros2Node, TellsWhatImagesItCannotRead) {
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
  EXPECT_EQ(std::ranges::count_if(told(), [](const std::string& one) { return one.find("tiles") != one.npos; }), 2);
  image.encoding = "rgb8";
  hand_in("left/image_rect", image);
  EXPECT_THAT(told(), Contains(HasSubstr("192×128 px, 192 bytes a row, but has 24576 bytes")));
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
    return std::ranges::count_if(told(), [](const std::string& one) { return one.starts_with("No image has come"); });
  }};
  ASSERT_TRUE(wait_for([&] { return silent() > 0; }));
  std::this_thread::sleep_for(2500ms);  // the number of seconds has changed
  EXPECT_EQ(silent(), 1) << ::testing::PrintToString(told());
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
    return std::ranges::count_if(told(), [](const std::string& one) { return one.find("connected") != one.npos; });
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

TEST_F(Ros2Node, EndsTheProcessAfterAnErrorOfItsThread) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  stand_in::world().publishing_fails = true;
  EXPECT_TRUE(wait_for([&] {
    hand_in_pair(0);
    return node_->has_failed();
  }));
  EXPECT_THAT(told(), Contains(HasSubstr("stopped: failed to publish message")));
  const std::scoped_lock lock{stand_in::world().mutex};
  EXPECT_TRUE(stand_in::world().is_shut_down);
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

TEST_F(Ros2Node, BeginsAnewWhereTheStampsStepBack) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(2);
  sensor_msgs::msg::Image left{message_of(scene_.load(0).left, begin_ns - 100 * second_ns)};
  sensor_msgs::msg::Image right{message_of(scene_.load(0).right, begin_ns - 100 * second_ns)};
  hand_in("left/image_rect", left);
  hand_in("right/image_rect", right);
  EXPECT_TRUE(wait_for([] { return published(grids).size() == 3; }));
  EXPECT_THAT(told(), Contains(HasSubstr("begins anew")));
}

TEST_F(Ros2Node, DeclaresEveryParameterOfThePipeline) {
  start({{"grid.length_m", std::int64_t{12}}, {"poses", std::string{"images"}}});  // 12 is as good as 12.0
  std::size_t parameters{0};
  stereogrid::Config config;
  visit_parameters(config, [&](std::string_view, const stereogrid::Parameter&, auto&) { ++parameters; });
  EXPECT_GT(node_->parameters(), parameters);
  hand_in_infos();
  hand_in_frames(2);
  EXPECT_EQ(published(grids).size(), 2U);
}

TEST_F(Ros2Node, RefusesParametersThatDoNotFit) {
  const auto refusal{[](const rclcpp::Parameter& parameter) -> std::string {
    try {
      StereoGridNode{rclcpp::NodeOptions{}.parameter_overrides({parameter})};
    } catch (const stereogrid::ConfigError& error) {
      return error.what();
    }
    return "";
  }};
  EXPECT_THAT(refusal({"grid.length_m", 1e6}), HasSubstr("grid.length_m"));
  EXPECT_THAT(refusal({"grid.length_m", std::string{"far"}}), HasSubstr("wrong type"));
  EXPECT_THAT(refusal({"matching.method", std::string{"guess"}}),
              HasSubstr("matching.method: guess (allowed correlation, semi_global)"));
  EXPECT_THAT(refusal({"poses", std::string{"gps"}}), HasSubstr("poses"));
  EXPECT_THAT(refusal({"input", std::string{"lidar"}}), HasSubstr("input: lidar (allowed stereo, depth, disparity)"));
  EXPECT_THAT(refusal({"device", std::string{"tpu"}}), HasSubstr("device"));
  EXPECT_THAT(refusal({"pair_tolerance", -1.0}), HasSubstr("pair_tolerance"));
}

/// Extrinsics in the node's own messages are read back unchanged.
TEST(Ros2Translate, MountingIsTheInverseOfTfStatic) {
  stereogrid::scenes::Scene scene{stereogrid::scenes::parse_scene("scene:street?width=192&height=128&frames=1")};
  stereogrid::Rig rig{scene.rig()};
  rig.camera_height_m = 1.3;
  rig.camera_pitch_rad = 0.15;
  rig.camera_roll_rad = -0.04;
  Kept kept;
  stereogrid::Pipeline pipeline{stereogrid::Config{}, rig};
  stereogrid::messages::FrameMessages messages{kept, rig, {.topics = {"tf_static"}}};
  messages.send(pipeline.process(scene.load(0)), {});
  stereogrid::messages::tf2_msgs::TFMessage tf;
  stereogrid::messages::decode(std::as_bytes(std::span{kept.messages["/tf_static"].back()}), tf);
  const auto& [t, q]{tf.transforms.at(0).transform};
  stereogrid::Rig read{scene.rig()};
  set_extrinsics(read, {{t.x, t.y, t.z}, {q.x, q.y, q.z, q.w}});
  EXPECT_NEAR(read.camera_height_m, 1.3, 1e-12);
  EXPECT_NEAR(read.camera_pitch_rad, 0.15, 1e-12);
  EXPECT_NEAR(read.camera_roll_rad, -0.04, 1e-12);
  EXPECT_THROW(set_extrinsics(read, {{0, 0, 1}, {0, 0, 0, 1}}), stereogrid::InputError);  // points up
  for (const double w : {0.0, 0.5, 1.02, std::nan("")})
    EXPECT_THROW(static_cast<void>(pose_of({{0, 0, 1}, {0, 0, 0, w}})), stereogrid::InputError) << w;
  EXPECT_THROW(set_extrinsics(read, {{0, 0, -1}, {-0.5, 0.5, -0.5, 0.5}}), stereogrid::InputError);  // below the road
}

}  // namespace
}  // namespace stereogrid_ros::testing
