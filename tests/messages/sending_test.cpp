// SPDX-License-Identifier: Apache-2.0
//
// Selection of messages and their receivers.
#include "stereogrid/error.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/pipeline.hpp"
#include "stereogrid/scenes/scene.hpp"
#include "support.hpp"

namespace stereogrid::messages::test {
namespace {

using diagnostic_msgs::DiagnosticArray;

constexpr std::int64_t second_ns{1'000'000'000};

// All messages of a street.
const Recorder& street() {
  static Recorder recorder;
  if (!recorder.sent.empty()) return recorder;
  const scenes::Scene scene{scenes::parse_scene("street?width=320&height=160&frames=12"), 2};
  Pipeline pipeline{preset("default"), scene.rig(), {.threads = 2, .horizons_s = {0.5}}};
  FrameMessages messages{recorder, pipeline.rig()};
  const std::array<std::byte, 2> bytes{};
  const auto jpeg = [&bytes](int) { return std::span{bytes}; };
  for (std::size_t i{0}; i < scene.size(); ++i) {
    const StereoFrame frame{scene.load(i)};
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns, .left_jpeg = jpeg, .u_disparity_jpeg = jpeg});
  }
  return recorder;
}

TEST(FrameMessages, AreOfTheseTypes) {
  const std::map<std::string, std::pair<std::string, bool>> expected{
      {"/stereo_grid/occupancy_grid", {"nav_msgs/msg/OccupancyGrid", true}},
      {"/stereo_grid/observed_grid", {"nav_msgs/msg/OccupancyGrid", true}},
      {"/stereo_grid/predicted_grid_0_5", {"nav_msgs/msg/OccupancyGrid", true}},
      {"/stereo_grid/planning_grid", {"nav_msgs/msg/OccupancyGrid", true}},
      {"/stereo_grid/grid_map", {"grid_map_msgs/msg/GridMap", true}},
      {"/stereo_grid/packed_grid", {"foxglove_msgs/msg/Grid", true}},
      {"/stereo_grid/obstacles", {"nav2_dynamic_msgs/msg/ObstacleArray", false}},
      {"/stereo_grid/detections", {"vision_msgs/msg/Detection3DArray", false}},
      {"/stereo_grid/obstacle_markers", {"visualization_msgs/msg/MarkerArray", false}},
      {"/stereo_grid/disparity", {"stereo_msgs/msg/DisparityImage", false}},
      {"/stereo_grid/points", {"sensor_msgs/msg/PointCloud2", false}},
      {"/stereo_grid/obstacle_points", {"sensor_msgs/msg/PointCloud2", false}},
      {"/stereo_grid/ground_points", {"sensor_msgs/msg/PointCloud2", false}},
      {"/stereo_grid/left/camera_info", {"sensor_msgs/msg/CameraInfo", false}},
      {"/stereo_grid/left/image_annotated/compressed", {"sensor_msgs/msg/CompressedImage", false}},
      {"/stereo_grid/u_disparity/compressed", {"sensor_msgs/msg/CompressedImage", false}},
      {"/stereo_grid/scan", {"sensor_msgs/msg/LaserScan", false}},
      {"/stereo_grid/odometry", {"nav_msgs/msg/Odometry", false}},
      {"/tf", {"tf2_msgs/msg/TFMessage", false}},
      {"/tf_static", {"tf2_msgs/msg/TFMessage", true}},
      {"/stereo_grid/status", {"diagnostic_msgs/msg/DiagnosticArray", false}},
      {"/diagnostics", {"diagnostic_msgs/msg/DiagnosticArray", false}}};
  std::map<std::string, std::pair<std::string, bool>> found;
  for (const Channel& channel : street().channels) {
    EXPECT_TRUE(found.insert({channel.topic, {std::string{channel.type}, channel.latched}}).second) << "added twice";
    EXPECT_FALSE(channel.definition.empty());
  }
  EXPECT_EQ(found, expected);
}

TEST(FrameMessages, OfAStreetHaveAllThatIsThere) {
  EXPECT_EQ(street().count("/stereo_grid/occupancy_grid"), 12u);
  EXPECT_EQ(street().count("/tf"), 12u);
  EXPECT_EQ(street().count("/tf_static"), 1u);
  const auto grid{street().last<nav_msgs::OccupancyGrid>("/stereo_grid/occupancy_grid")};
  EXPECT_EQ(grid.data.size(), std::size_t{grid.info.width} * grid.info.height);
  EXPECT_GT(std::ranges::count(grid.data, 0) + std::ranges::count(grid.data, 1), 0);
  const auto scan{street().last<sensor_msgs::LaserScan>("/stereo_grid/scan")};
  const auto hits{std::ranges::count_if(scan.ranges, [](float range) { return std::isfinite(range); })};
  EXPECT_GT(hits, std::ssize(scan.ranges) / 10);
  EXPECT_GT(street().last<sensor_msgs::PointCloud2>("/stereo_grid/points").width, 1'000u);
  EXPECT_FALSE(street().last<nav2_dynamic_msgs::ObstacleArray>("/stereo_grid/obstacles").obstacles.empty());
  EXPECT_NEAR(street().last<nav_msgs::Odometry>("/stereo_grid/odometry").twist.twist.linear.y, 0, 0.5);
}

TEST(FrameMessages, AreNotMadeWhereNobodyWantsThem) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  recorder.unwanted = {"/stereo_grid/occupancy_grid", "/tf"};
  messages.send(small_result(), {});
  EXPECT_EQ(recorder.type_of("/tf"), "tf2_msgs/msg/TFMessage") << "but can be asked for";
  EXPECT_EQ(recorder.count("/tf") + recorder.count("/stereo_grid/occupancy_grid"), 0u);
  EXPECT_EQ(recorder.count("/stereo_grid/scan"), 1u);
  recorder.unwanted.clear();
  messages.send(small_result(), {.stamp_ns = 5});
  EXPECT_EQ(recorder.count("/tf"), 1u);
}

TEST(FrameMessages, AreThoseThatWereSelected) {
  Recorder recorder;
  FrameResult result{small_result()};
  result.predictions.push_back({1, Image<float>{8, 6, 0.5f}, Image<float>{5, 4, 0.5f}});
  FrameMessages{recorder, small_rig(), {.node = "a/b", .topics = {"tf", "scan", "predicted_grid"}}}.send(result, {});
  EXPECT_EQ(recorder.channels.size(), 3u);
  EXPECT_EQ(recorder.count("/tf"), 1u);
  EXPECT_EQ(recorder.count("/a/b/scan"), 1u);
  EXPECT_EQ(recorder.count("/a/b/predicted_grid_1"), 1u);
}

TEST(FrameMessages, SayWhatIsWrong) {
  Recorder recorder;
  const auto error_text_of = [&](const FrameMessagesOptions& options) -> std::string {
    try {
      const FrameMessages messages{recorder, small_rig(), options};
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_THAT(error_text_of({.topics = {"scan", "lidar"}}), HasSubstr("no topic \"lidar\""));
  EXPECT_THAT(error_text_of({.topics = {"lidar"}}), HasSubstr("left/image_annotated/compressed"));
  for (const char* const node : {"", "/a", "a/", "a//b", "a b", "ä"}) {
    EXPECT_THAT(error_text_of({.node = node}), HasSubstr("not a name of a node")) << node;
  }
  EXPECT_THAT(error_text_of({.world_frame = ""}), HasSubstr("needs a name"));
  EXPECT_THROW((FrameMessages{recorder, Rig{}}), InputError);
  FrameMessages messages{recorder, small_rig()};
  EXPECT_THROW(messages.set_rig(Rig{}), InputError);
}

std::map<std::string, std::string> values_of(const DiagnosticArray& array) {
  std::map<std::string, std::string> values;
  for (const diagnostic_msgs::KeyValue& one : array.status.at(0).values) values[one.key] = one.value;
  return values;
}

TEST(StatusMessage, HasCountsTimesAndTheGround) {
  FrameResult result{small_result()};
  result.ground = {.height_m = 1.25, .pitch_rad = -0.5, .estimated = true};
  result.timing_ms.match = 12.5;
  result.road_density = 0.25;
  result.obstacles.resize(3);
  result.obstacles[1].confirmed = true;
  result.speed_limit_mps = 2.5;
  result.speed_limit_reason = SpeedReason::ditches;
  const std::vector<Dropped> dropped{{"no pair", 3}, {"too late", 4}};
  const auto array{sent_on<DiagnosticArray>("/stereo_grid/status", result,
                                            {.latency = {{31.5, 30, 40.25}}, .frames = 100, .dropped = dropped})};
  EXPECT_EQ(array.status.at(0).name, "stereo_grid");
  EXPECT_EQ(array.status.at(0).level, std::byte{0});
  auto values{values_of(array)};
  EXPECT_EQ(values["frames"], "100");
  EXPECT_EQ(values["dropped"], "7");
  EXPECT_EQ(values["dropped: too late"], "4");
  EXPECT_EQ(values["latency_ms"], "31.5");
  EXPECT_EQ(values["latency_median_ms"], "30");
  EXPECT_EQ(values["latency_p99_ms"], "40.25");
  EXPECT_EQ(values["match_ms"], "12.5");
  EXPECT_EQ(values["ground_height_m"], "1.25");
  EXPECT_EQ(values["ground_estimated"], "true");
  EXPECT_EQ(values["road_density"], "0.25");
  EXPECT_EQ(values["obstacles"], "1") << "confirmed";
  EXPECT_EQ(values["speed_limit_mps"], "2.5");
  EXPECT_EQ(values["speed_limit_reason"], "ditches");
}

TEST(StatusMessage, WarnsOfAPoorFrame) {
  FrameResult result{small_result()};
  result.status = {FrameStatus::pose_missing, FrameStatus::few_matches};
  auto array{sent_on<DiagnosticArray>("/stereo_grid/status", result)};
  EXPECT_EQ(array.status.at(0).level, std::byte{1});
  EXPECT_EQ(array.status.at(0).message, "pose_missing, few_matches");
  result.warnings = {{"The lens is dirty."}};
  EXPECT_EQ(sent_on<DiagnosticArray>("/stereo_grid/status", result).status.at(0).message, "The lens is dirty.");
}

TEST(StatusMessage, WarnsWhenAThirdOfTheFramesIsDropped) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig(), {.camera_frame = "eyes"}};
  std::vector<Dropped> dropped{{"no pair", 50}};
  const auto status_after = [&](std::int64_t second, std::int64_t frames, std::int64_t dropped_frames) {
    dropped[0].frames = dropped_frames;
    messages.send(small_result(), {.stamp_ns = second * second_ns, .frames = frames, .dropped = dropped});
    return recorder.last<DiagnosticArray>("/diagnostics").status.at(0);
  };
  EXPECT_EQ(status_after(0, 1, 50).level, std::byte{1}) << "before the first frame";
  EXPECT_EQ(status_after(1, 21, 59).level, std::byte{0});
  const auto poor{status_after(2, 41, 69)};
  EXPECT_EQ(poor.level, std::byte{1});
  EXPECT_EQ(poor.message, "10 of the last 30 frames dropped");
  EXPECT_EQ(poor.hardware_id, "eyes");
  EXPECT_EQ(status_after(3, 61, 69).message, "fine");
  EXPECT_EQ(status_after(4, 3, 0).message, "fine") << "counts begin again";
}

TEST(StatusMessage, ComesOnceASecondAsDiagnostics) {
  Recorder recorder;
  FrameMessages messages{recorder, small_rig()};
  for (int tenth{0}; tenth < 25; ++tenth) messages.send(small_result(), {.stamp_ns = tenth * second_ns / 10});
  EXPECT_EQ(recorder.count("/stereo_grid/status"), 25u);
  EXPECT_EQ(recorder.count("/diagnostics"), 3u);
  messages.send(small_result(), {.stamp_ns = -5 * second_ns});
  EXPECT_EQ(recorder.count("/diagnostics"), 4u) << "the clock has stepped back";
}

TEST(Tee, SendsToAllThatWant) {
  Recorder first;
  Recorder second;
  static_cast<void>(first.add({"/other", "x", "y", false}));  // numbers differ
  Tee tee{{&first, &second}};
  FrameMessages messages{tee, small_rig()};
  second.unwanted = {"/stereo_grid/scan"};
  messages.send(small_result(), {});
  EXPECT_EQ(first.count("/stereo_grid/scan"), 1u);
  EXPECT_EQ(second.count("/stereo_grid/scan"), 0u);
  EXPECT_EQ(first.last<nav_msgs::OccupancyGrid>("/stereo_grid/occupancy_grid").data.size(), 20u);
  EXPECT_EQ(second.last<nav_msgs::OccupancyGrid>("/stereo_grid/occupancy_grid").data.size(), 20u);
  first.unwanted = {"/stereo_grid/scan"};
  messages.send(small_result(), {.stamp_ns = 1});
  EXPECT_EQ(first.count("/stereo_grid/scan"), 1u);
}

}  // namespace
}  // namespace stereogrid::messages::test
