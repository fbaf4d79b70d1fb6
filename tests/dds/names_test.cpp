// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "names.hpp"

#include <cstdlib>

#include "stereogrid/error.hpp"
#include "support.hpp"

namespace stereogrid::dds::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

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
    EXPECT_THAT([&] { Names{{.name = name}}; }, ThrowsMessage<ConfigError>(HasSubstr("no name of a ROS 2 node")))
        << name;
  }
  for (const char* text : {"", ":=", "a", "a:=", ":=b", "a:=b c", "a=b"}) {
    EXPECT_THAT([&] { (Names{{.remappings = {text}}}); }, ThrowsMessage<ConfigError>(HasSubstr("no remapping")))
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

TEST(DdsNames, WhatTheNetworkComplainsOfIsToldAndEndsTheStart) {
  Warned warned;
  setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain><Nonsense/></Domain></CycloneDDS>", 1);
  EXPECT_THAT([&] { (void)open_node({.warn = warned.taker()}); },
              ThrowsMessage<DeviceError>(HasSubstr("check CYCLONEDDS_URI")));
  EXPECT_THAT(warned.sentences(), ::testing::Contains(AllOf(HasSubstr("ROS 2: config:"), HasSubstr("Nonsense"))));
}

}  // namespace
}  // namespace stereogrid::dds::testing
