// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/messages/definition.hpp"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "types.hpp"

namespace stereogrid::messages::test {
namespace {

TEST(Definition, OfAGridIsKnown) {
  const std::string line(80, '=');
  EXPECT_EQ(definition_of<nav_msgs::OccupancyGrid>(),
            "std_msgs/Header header\n"
            "nav_msgs/MapMetaData info\n"
            "int8[] data\n" +
                line + "\nMSG: std_msgs/Header\n" +
                "builtin_interfaces/Time stamp\n"
                "string frame_id\n" +
                line + "\nMSG: builtin_interfaces/Time\n" +
                "int32 sec\n"
                "uint32 nanosec\n" +
                line + "\nMSG: nav_msgs/MapMetaData\n" +
                "builtin_interfaces/Time map_load_time\n"
                "float32 resolution\n"
                "uint32 width\n"
                "uint32 height\n"
                "geometry_msgs/Pose origin\n" +
                line + "\nMSG: geometry_msgs/Pose\n" +
                "geometry_msgs/Point position\n"
                "geometry_msgs/Quaternion orientation\n" +
                line + "\nMSG: geometry_msgs/Point\n" +
                "float64 x\n"
                "float64 y\n"
                "float64 z\n" +
                line + "\nMSG: geometry_msgs/Quaternion\n" +
                "float64 x\n"
                "float64 y\n"
                "float64 z\n"
                "float64 w\n");
}

TEST(Definition, NamesEveryKindOfField) {
  EXPECT_EQ(definition_of<diagnostic_msgs::DiagnosticStatus>(),
            "byte level\nstring name\nstring message\nstring hardware_id\ndiagnostic_msgs/KeyValue[] values\n" +
                std::string(80, '=') + "\nMSG: diagnostic_msgs/KeyValue\nstring key\nstring value\n");
  EXPECT_EQ(definition_of<unique_identifier_msgs::UUID>(), "uint8[16] uuid\n");
  EXPECT_TRUE(definition_of<sensor_msgs::CameraInfo>().find("float64[] d\nfloat64[9] k\n") != std::string::npos);
  EXPECT_TRUE(definition_of<sensor_msgs::CameraInfo>().find("bool do_rectify\n") != std::string::npos);
  EXPECT_TRUE(definition_of<grid_map_msgs::GridMap>().find("string[] layers\n") != std::string::npos);
}

// Each type that is used is described once, however often it is used.
TEST(Definition, DescribesAllThatIsUsedOnce) {
  for_each_type([]<Message M>(const M& /*type*/) {
    std::set<std::string> used;
    std::multiset<std::string> described;
    std::istringstream lines{std::string{definition_of<M>()}};
    for (std::string type, name; lines >> type >> name;) {
      if (type == "MSG:") described.insert(name);
      if (type.starts_with("====")) described.insert((lines >> type, type));
      if (type.find('/') != std::string::npos && name != "MSG:") used.insert(type.substr(0, type.find('[')));
    }
    EXPECT_EQ(described, std::multiset<std::string>(used.begin(), used.end())) << M::type_name;
  });
}

}  // namespace
}  // namespace stereogrid::messages::test
