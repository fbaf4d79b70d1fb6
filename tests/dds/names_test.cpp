// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include "../messages/random_filler.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/messages/definition.hpp"
#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

TEST(DdsNames, AreThoseOfRos) {
  EXPECT_EQ(dds_topic("/a/b"), "rt/a/b");
  EXPECT_EQ(dds_type("nav_msgs/msg/OccupancyGrid"), "nav_msgs::msg::dds_::OccupancyGrid_");
  const auto topic{ros_topic("rt/a/b", "nav_msgs::msg::dds_::OccupancyGrid_")};
  ASSERT_TRUE(topic);
  EXPECT_EQ(topic->name, "/a/b");
  EXPECT_EQ(topic->type, "nav_msgs/msg/OccupancyGrid");
  EXPECT_FALSE(ros_topic("rq/a/bRequest", "nav_msgs::srv::dds_::GetMap_Request_"));
  EXPECT_FALSE(ros_topic("Square", "ShapeType"));
  EXPECT_FALSE(ros_topic("rt/a\033[2J", "nav_msgs::msg::dds_::OccupancyGrid_"));
  EXPECT_FALSE(ros_topic("rt/a", "nav_msgs::msg::dds_::_"));
}

TEST(DdsNames, FollowTheNodeAndItsRemappings) {
  const Names plain{{}};
  EXPECT_EQ(plain.node_namespace(), "/");
  EXPECT_EQ(plain.topic("/stereo_grid/scan"), "/stereo_grid/scan");
  EXPECT_EQ(plain.topic("/tf"), "/tf");
  const Names robot{
      {.name = "/robot/front/grid", .remappings = {"occupancy_grid:=/map", "/tf:=/robot/tf", "scan:=s2"}}};
  EXPECT_EQ(robot.node_namespace(), "/robot/front");
  EXPECT_EQ(robot.node(), "grid");
  EXPECT_EQ(robot.topic("/stereo_grid/occupancy_grid"), "/map");
  EXPECT_EQ(robot.topic("/stereo_grid/scan"), "/robot/front/grid/s2");
  EXPECT_EQ(robot.topic("/stereo_grid/left/camera_info"), "/robot/front/grid/left/camera_info");
  EXPECT_EQ(robot.topic("/tf"), "/robot/tf");
  EXPECT_EQ(robot.remapped("/tf"), "/robot/tf");
  EXPECT_EQ(robot.remapped("/stereo_grid/scan"), "/stereo_grid/scan");  // a topic of another node
}

TEST(DdsNames, ThatRosDoesNotTakeAreRefused) {
  for (const char* name : {"", "/", "a//b", "a/", "1st", "a b", "grün", "a-b"}) {
    EXPECT_THAT([&] { Names{{.name = name}}; }, ThrowsMessage<ConfigError>(HasSubstr("not a name of a ROS 2 node")))
        << name;
  }
  for (const char* text : {"", ":=", "a", "a:=", ":=b", "a:=b c", "a=b"}) {
    EXPECT_THAT([&] { (Names{{.remappings = {text}}}); }, ThrowsMessage<ConfigError>(HasSubstr("not a remapping")))
        << text;
  }
}

TEST(DdsNames, SoAreVariablesThatMakeNoSense) {
  for (const char* id : {"-1", "233", "x", "1 ", "1.5", "99999999999"}) {
    setenv("ROS_DOMAIN_ID", id, 1);
    EXPECT_THAT([] { check_options({}); }, ThrowsMessage<ConfigError>(HasSubstr("from 0 to 232"))) << id;
  }
  setenv("ROS_DOMAIN_ID", "232", 1);
  check_options({});
  setenv("ROS_LOCALHOST_ONLY", "yes", 1);
  EXPECT_THAT([] { check_options({}); }, ThrowsMessage<ConfigError>(HasSubstr("it is 0 or 1")));
  unsetenv("ROS_LOCALHOST_ONLY");
  setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "HERE", 1);
  EXPECT_THAT([] { check_options({}); }, ThrowsMessage<ConfigError>(HasSubstr("SUBNET, LOCALHOST")));
  unsetenv("ROS_AUTOMATIC_DISCOVERY_RANGE");
  setenv("ROS_STATIC_PEERS", "10.0.0.7;\"/>", 1);
  EXPECT_THAT([] { check_options({}); }, ThrowsMessage<ConfigError>(HasSubstr("names of hosts")));
  setenv("ROS_STATIC_PEERS", "10.0.0.7;;robot.local;[fe80::1]", 1);
  check_options({});
}

TEST(DdsNames, ErrorsOfTheNetworkAreReportedAndEndTheStart) {
  Warned warned;
  setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>", 1);
  EXPECT_THAT([&] { (void)open_node({.warn = warned.taker()}); },
              ThrowsMessage<DeviceError>(HasSubstr("check CYCLONEDDS_URI")));
  EXPECT_THAT(warned.sentences(), ::testing::Contains(AllOf(HasSubstr("ROS 2: config:"), HasSubstr("Nonsense"))));
}

using namespace messages;

// Source: the packages of ROS 2 Jazzy. tf2_msgs, grid_map_msgs, nav2_dynamic_msgs and vision_msgs:
// rosidl_generator_type_description 4.6.6 applied to their definitions. foxglove_msgs has no package of ROS in that
// list.
const std::map<std::string_view, std::string_view> hashes_of_ros{
    {"nav_msgs/msg/OccupancyGrid", "RIHS01_8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"},
    {"nav_msgs/msg/Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"},
    {"grid_map_msgs/msg/GridMap", "RIHS01_343b0e72887541beda6b035cc053f2d6fffaad9d6dcb2773c15a808dfca31fde"},
    {"nav2_dynamic_msgs/msg/ObstacleArray", "RIHS01_30bef8eb1da85ccb8d8fd860be402b7710dd81b368d1622325aa617436b0cb2a"},
    {"vision_msgs/msg/Detection3DArray", "RIHS01_793f5eab9595ac1c0da07873cc859db42eae51f0ee76056db8562515d830e018"},
    {"visualization_msgs/msg/MarkerArray", "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf"},
    {"stereo_msgs/msg/DisparityImage", "RIHS01_1ec1ff6b5bace919e4544a37f2d96ead9f81783701b7b7a4d97a09325ecf2711"},
    {"sensor_msgs/msg/PointCloud2", "RIHS01_9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"},
    {"sensor_msgs/msg/CompressedImage", "RIHS01_15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a"},
    {"sensor_msgs/msg/LaserScan", "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"},
    {"sensor_msgs/msg/Image", "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"},
    {"sensor_msgs/msg/CameraInfo", "RIHS01_b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"},
    {"tf2_msgs/msg/TFMessage", "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"},
    {"diagnostic_msgs/msg/DiagnosticArray", "RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e"}};

TEST(DdsTypeHashes, AreThoseOfRos) {
  std::size_t found{0};
  messages::test::for_each_type([&]<Message M>(const M& /*type*/) {
    const std::string hash{type_hash(M::type_name, definition_of<M>())};
    EXPECT_THAT(hash, ::testing::MatchesRegex("RIHS01_[0-9a-f]{64}")) << M::type_name;
    const auto known{hashes_of_ros.find(M::type_name)};
    if (known == hashes_of_ros.end()) return;
    ++found;
    EXPECT_EQ(hash, known->second) << M::type_name;
  });
  EXPECT_EQ(found, hashes_of_ros.size());
}

TEST(DdsTypeHashes, OfTypesThatAreSubscribedTo) {
  for (const char* type : {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo",
                           "stereo_msgs/msg/DisparityImage", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"}) {
    EXPECT_EQ(type_hash(type, definition_of_subscribed(type)), hashes_of_ros.at(type));
  }
  EXPECT_EQ(definition_of_subscribed("std_msgs/msg/String"), "");
}

TEST(DdsTypeHashes, RefuseFieldsWithoutARule) {
  EXPECT_THROW(static_cast<void>(type_hash("a/msg/B", "wstring name\n")), InputError);
}

}  // namespace

}  // namespace stereogrid::dds::testing
