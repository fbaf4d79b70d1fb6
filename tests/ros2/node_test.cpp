// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>

#include "node_support.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/nav_msgs.hpp"

namespace stereogrid_ros::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

/// Two cameras back to back.
class Ros2Cameras : public Ros2Node {
 protected:
  void SetUp() override {
    Ros2Node::SetUp();
    stand_in::lookup() = [this](const std::string& target, const std::string& source, std::int64_t) {
      return target == "base_footprint" ? places_.at(source) : std::optional<geometry_msgs::msg::Transform>{};
    };
  }

  [[nodiscard]] sensor_msgs::msg::CameraInfo info(std::size_t camera, bool is_right) const {
    const stereogrid::Rig& rig{around_.rigs()[camera]};
    sensor_msgs::msg::CameraInfo message{info_of(rig, is_right ? rig.baseline_m : 0)};
    message.header.frame_id = names_.at(camera) + "_optical";
    return message;
  }
  /// As the node reads it.
  [[nodiscard]] stereogrid::Rig rig(std::size_t camera) const {
    const auto read = [&](bool is_right) { return camera_of(info(camera, is_right), "camera"); };
    stereogrid::Rig rig{stereogrid::io::ros_calibration(read(false), read(true), true).rig};
    const auto& place{*places_.at(names_.at(camera) + "_optical")};
    set_extrinsics(rig, place);
    const stereogrid::Pose2 pose{pose_of(place)};
    rig.camera_x_m = pose.x_m;
    rig.camera_y_m = pose.y_m;
    rig.camera_yaw_rad = pose.yaw_rad;
    return rig;
  }
  void hand_in_infos() const {
    for (const std::size_t camera : {1U, 0U}) {  // both are there when the first one is opened
      hand_in(names_.at(camera) + "/left/camera_info", info(camera, false));
      hand_in(names_.at(camera) + "/right/camera_info", info(camera, true));
    }
    std::this_thread::sleep_for(200ms);
  }
  void hand_in_images(std::size_t camera, const stereogrid::StereoFrame& frame) const {
    hand_in(names_.at(camera) + "/left/image_rect", message_of(frame.left, begin_ns + frame.stamp_ns));
    hand_in(names_.at(camera) + "/right/image_rect", message_of(frame.right, begin_ns + frame.stamp_ns));
  }

  const std::vector<std::string> names_{"front", "/robot/rear"};
  stereogrid::scenes::Scene around_{
      stereogrid::scenes::parse_scene("scene:around?cameras=2&turn_deg=180&width=192&height=128&focal=96&frames=6")};
  std::map<std::string, std::optional<geometry_msgs::msg::Transform>> places_{
      {"front_optical", geometry_msgs::msg::Transform{{0.5, 0, 1.25}, {-0.5, 0.5, -0.5, 0.5}}},
      {"/robot/rear_optical", geometry_msgs::msg::Transform{{-0.5, 0, 1.25}, {-0.5, -0.5, 0.5, 0.5}}}};
};

TEST_F(Ros2Cameras, MakeOneGridAndTheRearOneGoesOnAlone) {
  Kept kept;
  const std::array rigs{rig(0), rig(1)};
  EXPECT_NEAR(rigs[1].camera_yaw_rad, std::numbers::pi, 1e-9);
  stereogrid::Config config;
  config.grid.rear_m = 10;
  stereogrid::Pipeline pipeline{config, rigs};
  stereogrid::messages::FrameMessages messages{kept, rigs[0], {.topics = {"occupancy_grid"}}};
  start({{"poses", std::string{"none"}}, {"cameras", names_}, {"grid.rear_m", 10.0}});
  hand_in_infos();
  for (std::size_t i{0}; i < around_.size(); ++i) {
    stereogrid::StereoFrame frame{around_.load(i)};
    const bool is_alone{i + 1 == around_.size()};
    hand_in_images(1, frame.others.at(0));
    if (!is_alone) hand_in_images(0, frame);
    frame.stamp_ns += begin_ns;
    frame.others[0].stamp_ns += begin_ns;
    frame.world_from_vehicle.reset();
    frame.others[0].world_from_vehicle.reset();
    if (is_alone) frame.left = frame.right = {};
    messages.send(pipeline.process(frame), {.stamp_ns = frame.stamp_ns});
    ASSERT_TRUE(wait_for([&] { return published(grids).size() == i + 1; })) << i;
  }
  EXPECT_TRUE(published(grids) == kept.messages[grids]);
  EXPECT_TRUE(wait_for([] { return ::testing::Matches(Contains(HasSubstr("front: ")))(logged()); }));
}

TEST_F(Ros2Cameras, AreRefusedTwiceOrWithoutAFrameForTheirPlaces) {
  using Names = std::vector<std::string>;
  EXPECT_THROW(start({{"cameras", Names{"front", "front/"}}}), stereogrid::ConfigError);
  EXPECT_THROW(start({{"cameras", Names(9, "front")}}), stereogrid::ConfigError);
  EXPECT_THROW(start({{"cameras", Names{"front", "rear"}}, {"robot_base_frame", std::string{}}}),
               stereogrid::ConfigError);
  places_["/robot/rear_optical"].reset();
  start({{"poses", std::string{"none"}}, {"cameras", names_}, {"transform_tolerance", 0.05}});
  hand_in_infos();
  EXPECT_TRUE(wait_for([] { return ::testing::Matches(Contains(HasSubstr("TF: ")))(logged()); }));
  EXPECT_THAT(published(grids), IsEmpty());
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

TEST_F(Ros2Node, LeavesTopicsOutWhosePackagesAreMissing) {
  stand_in::world().missing_packages = {"nav2_dynamic_msgs", "foxglove_msgs"};
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const auto left_out{Contains(HasSubstr("/stereo_grid/obstacles is not published: package 'nav2_dynamic_msgs'"))};
  EXPECT_TRUE(wait_for([&] { return ::testing::Matches(left_out)(logged()); }));
  EXPECT_TRUE(wait_for([] { return published("/stereo_grid/observed_grid").size() == 1; }));
  EXPECT_THAT(published("/stereo_grid/obstacles"), IsEmpty());
}

TEST_F(Ros2Node, RestartsWhereTheStampsStepBack) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(2);
  sensor_msgs::msg::Image left{message_of(scene_.load(0).left, begin_ns - 100 * second_ns)};
  sensor_msgs::msg::Image right{message_of(scene_.load(0).right, begin_ns - 100 * second_ns)};
  hand_in("left/image_rect", left);
  hand_in("right/image_rect", right);
  EXPECT_TRUE(wait_for([] { return published(grids).size() == 3; }));
  EXPECT_THAT(logged(), Contains(HasSubstr("restart")));
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
  EXPECT_THAT(refusal({"ground.model", std::string{"guess"}}),
              HasSubstr("ground.model: guess (allowed plane, terrain)"));
  EXPECT_THAT(refusal({"poses", std::string{"gps"}}), HasSubstr("poses"));
  EXPECT_THAT(refusal({"input", std::string{"lidar"}}), HasSubstr("input: lidar (allowed stereo, depth, disparity)"));
  EXPECT_THAT(refusal({"device", std::string{"tpu"}}), HasSubstr("device"));
  EXPECT_THAT(refusal({"pair_tolerance", -1.0}), HasSubstr("pair_tolerance"));
  EXPECT_THAT(refusal({"topics", std::vector<std::string>{"scan", "grids"}}), HasSubstr("There is no topic \"grids\""));
  EXPECT_THAT(refusal({"points_voxel", -1.0}), HasSubstr("points_voxel"));
  EXPECT_THAT(refusal({"value_scale", std::string{"autoware"}}), HasSubstr("global_frame: odom (allowed map"));
}

TEST_F(Ros2Node, ReadsParametersWhenItIsConfigured) {
  constexpr std::uint8_t unconfigured{1};
  constexpr std::uint8_t inactive{2};
  start({{"autostart", false}, {"poses", std::string{"gps"}}, {"filter.decay", 1.0}, {"grid.length_m", 20.0}});
  EXPECT_EQ(node_->configure().id(), unconfigured);
  EXPECT_THAT(logged(), Contains("parameter poses: gps (allowed tf, images, none)."));
  EXPECT_TRUE(node_->set_parameter({"poses", std::string{"none"}}).successful);
  EXPECT_TRUE(node_->set_parameter({"grid.length_m", std::int64_t{12}}).successful);
  EXPECT_EQ(node_->configure().id(), inactive);
  EXPECT_THAT(logged(), Contains("parameter filter.decay is unknown, and has no effect."));
  EXPECT_THAT(logged(), ::testing::Not(Contains("parameter grid.length_m is unknown, and has no effect.")));
  EXPECT_EQ(node_->set_parameter({"grid.length_m", 15.0}).reason,
            "parameter grid.length_m is read by configure: deactivate and clean up the node first.");
  EXPECT_EQ(node_->get_parameter("grid.length_m").as_int(), 12);
  node_->activate();
  hand_in_infos();
  hand_in_frames(1);
  ASSERT_EQ(published(grids).size(), 1U) << "with the parameters of the last configuration";
  stereogrid::messages::nav_msgs::OccupancyGrid grid;
  stereogrid::messages::decode(std::as_bytes(std::span{published(grids).back()}), grid);
  EXPECT_LT(static_cast<double>(grid.info.height) * static_cast<double>(grid.info.resolution), 40);
  node_->deactivate();
  node_->cleanup();
  EXPECT_TRUE(node_->set_parameter({"grid.length_m", 1e6}).successful);
  EXPECT_EQ(node_->configure().id(), unconfigured);
  EXPECT_THAT(logged(), Contains(HasSubstr("grid.length_m")));
}

TEST_F(Ros2Node, TakesThresholdsBetweenFrames) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const auto points{[] {
    stereogrid::messages::sensor_msgs::PointCloud2 cloud;
    const auto messages{published("/stereo_grid/points")};
    if (!messages.empty()) stereogrid::messages::decode(std::as_bytes(std::span{messages.back()}), cloud);
    return cloud.width;
  }};
  ASSERT_TRUE(wait_for([&] { return points() > 0; }));
  const std::uint32_t before{points()};
  EXPECT_TRUE(node_->set_parameter({"points_voxel", std::int64_t{0}}).successful);
  hand_in_pair(1);
  EXPECT_TRUE(wait_for([&] { return points() > 2 * before; })) << before << " " << points();

  const auto pairs_at{[&](std::int64_t late_ns) {  // true: there is a grid
    const stereogrid::StereoFrame frame{scene_.load(3)};
    const std::size_t count{published(grids).size()};
    const std::int64_t at_ns{begin_ns + late_ns * 100};
    hand_in("left/image_rect", message_of(frame.left, at_ns));
    hand_in("right/image_rect", message_of(frame.right, at_ns + late_ns));
    return wait_for_grid(count);
  }};
  EXPECT_FALSE(pairs_at(50'000'000));
  EXPECT_TRUE(node_->set_parameter({"pair_tolerance", 0.2}).successful);
  std::this_thread::sleep_for(300ms);  // the thread reads it ten times a second
  EXPECT_TRUE(pairs_at(100'000'000));

  EXPECT_THAT(node_->set_parameter({"transform_tolerance", -1.0}).reason, HasSubstr("(allowed 0 to 60)"));
  EXPECT_THAT(node_->set_parameter({"points_voxel", 11.0}).reason, HasSubstr("(allowed 0, or 0.01 to 10)"));
  EXPECT_THAT(node_->set_parameter({"points_voxel", std::string{"all"}}).reason, HasSubstr("wrong type"));
  EXPECT_EQ(node_->get_parameter("points_voxel").as_int(), 0);
}

TEST_F(Ros2Node, EncodesOnlyWhatIsSubscribedTo) {
  stand_in::world().subscriptions = {{"/stereo_grid/points", 0},
                                     {"/stereo_grid/obstacle_markers", 0},
                                     {"/stereo_grid/disparity", 0},
                                     {"/stereo_grid/status", 0}};
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(2);
  EXPECT_TRUE(wait_for([] { return published("/stereo_grid/scan").size() == 2; }));
  for (const char* topic : {"points", "obstacle_markers", "disparity", "status"}) {
    EXPECT_THAT(published(std::string{"/stereo_grid/"} + topic), IsEmpty()) << topic;
  }
  stand_in::world().subscriptions.clear();
}

TEST_F(Ros2Node, WarnsInDiagnosticsWhereAThirdOfTheFramesIsDropped) {
  start({{"poses", std::string{"none"}}});
  hand_in_infos();
  hand_in_frames(1);
  const auto last_status{[] {
    stereogrid::messages::diagnostic_msgs::DiagnosticArray array;
    const auto messages{published("/diagnostics")};
    if (!messages.empty()) stereogrid::messages::decode(std::as_bytes(std::span{messages.back()}), array);
    return array.status.empty() ? stereogrid::messages::diagnostic_msgs::DiagnosticStatus{} : array.status.front();
  }};
  const stereogrid::StereoFrame frame{scene_.load(1)};
  for (std::int64_t i{1}; i <= 12; ++i) {  // 5 Hz; one right image in two is missing
    const std::size_t count{published(grids).size()};
    hand_in("left/image_rect", message_of(frame.left, begin_ns + i * second_ns / 5));
    if (i % 2 == 1) continue;
    hand_in("right/image_rect", message_of(frame.right, begin_ns + i * second_ns / 5));
    ASSERT_TRUE(wait_for_grid(count));
  }
  EXPECT_TRUE(wait_for([&] { return last_status().message.find("frames dropped") != std::string::npos; }));
  EXPECT_EQ(last_status().level, std::byte{1});
  EXPECT_EQ(last_status().name, "stereo_grid");
  EXPECT_EQ(last_status().hardware_id, "stereo_grid_left_optical");
}

TEST_F(Ros2Node, HasTheCovariancesOfVisualOdometryOnly) {
  for (const char* poses : {"images", "tf"}) {
    node_.reset();
    stand_in::world().published.clear();
    start({{"poses", std::string{poses}}});
    hand_in_infos();
    hand_in_frames(3);
    ASSERT_TRUE(wait_for([] { return published("/stereo_grid/odometry").size() == 3; }));
    stereogrid::messages::nav_msgs::Odometry odometry;
    stereogrid::messages::decode(std::as_bytes(std::span{published("/stereo_grid/odometry").back()}), odometry);
    const double variance{odometry.pose.covariance[0]};
    EXPECT_EQ(variance > 0, std::string{poses} == "images") << variance;
    EXPECT_LT(variance, 0.01);
    EXPECT_EQ(odometry.twist.covariance[35] > 0, std::string{poses} == "images");
  }
}

TEST_F(Ros2Node, ReadsTransformsWithItsOwnRemappings) {
  start({{"poses", std::string{"none"}}});
  EXPECT_EQ(tf2_ros::TransformListener::last_node(), &*node_);
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
