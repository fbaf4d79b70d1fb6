// SPDX-License-Identifier: Apache-2.0
//
// The encoding, on bytes written by hand and on random messages of every type.
#include "stereogrid/messages/cdr.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <initializer_list>
#include <set>
#include <sstream>

#include "random_filler.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/messages/definition.hpp"

namespace stereogrid::messages::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes(std::initializer_list<int> values) {
  Bytes all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

template <Message M>
Bytes encoded(const M& message) {
  CdrWriter writer;
  const auto cdr{writer.encode(message)};
  return {cdr.begin(), cdr.end()};
}

template <Message M>
std::string error_text_of(const Bytes& cdr) {
  M message;
  try {
    decode(cdr, message);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// Numbers of all sizes, and arrays of them, at odd places.
struct Sizes {
  STEREOGRID_MESSAGE("test/msg/Sizes", a, b, c, d, e, f, g);

  std::uint8_t a{0};
  double b{0};
  std::vector<double> c;
  bool d{false};
  std::uint16_t e{0};
  std::array<std::int8_t, 5> f{};
  std::vector<double> g;
};

TEST(Cdr, WritesAHeaderAsKnown) {
  EXPECT_EQ(encoded(std_msgs::Header{{1, 0x01020304}, "odom"}),
            bytes({0, 1, 0, 0, 1, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 'o', 'd', 'o', 'm', 0}));
}

TEST(Cdr, AlignsToTheSizeOfANumber) {
  EXPECT_EQ(encoded(sensor_msgs::PointField{"x", 4, 7, 1}),
            bytes({0, 1, 0, 0, 2, 0, 0, 0, 'x', 0, 0, 0, 4, 0, 0, 0, 7, 0, 0, 0, 1, 0, 0, 0}));
}

TEST(Cdr, FillsUpBeforeElementsThatThereAreOnly) {
  const Sizes sizes{1, 1.0, {}, true, 0x0203, {4, 5, -1, 6, 7}, {2.0}};
  EXPECT_EQ(encoded(sizes), bytes({0, 1, 0,    0,                    //
                                   1, 0, 0,    0, 0, 0, 0,    0,     // a
                                   0, 0, 0,    0, 0, 0, 0xf0, 0x3f,  // b
                                   0, 0, 0,    0,                    // c is empty: d follows without a gap
                                   1, 0, 3,    2,                    // d, e
                                   4, 5, 0xff, 6, 7, 0, 0,    0,     // f
                                   1, 0, 0,    0, 0, 0, 0,    0,     // g has one element
                                   0, 0, 0,    0, 0, 0, 0,    0x40}));
}

TEST(Cdr, WritesAGridAsKnown) {
  nav_msgs::OccupancyGrid grid;
  grid.header.frame_id = "o";
  grid.info.resolution = 0.5f;
  grid.info.width = 2;
  grid.info.height = 1;
  grid.data = {100, -1};
  const Bytes cdr{encoded(grid)};
  // header 16, time 8, resolution 4, size 8, padding 4, pose 56, count 4, cells 2
  ASSERT_EQ(cdr.size(), 4u + 16 + 8 + 4 + 8 + 4 + 56 + 4 + 2);
  EXPECT_EQ(Bytes(cdr.begin() + 24, cdr.begin() + 32), bytes({0, 0, 0, 0, 0, 0, 0, 0x3f}));
  EXPECT_EQ(Bytes(cdr.end() - 6, cdr.end()), bytes({2, 0, 0, 0, 100, 0xff}));
}

// Compares bytes, so that a NaN equals itself.
TEST(Cdr, ComesBackAsItWas) {
  for_each_type([]<Message M>(const M& /*type*/) {
    M again;  // kept: what it holds from the message before must not stay
    for (unsigned seed{0}; seed < 200; ++seed) {
      M message;
      RandomFiller{seed}.fill(message);
      const Bytes cdr{encoded(message)};
      decode(cdr, again);
      EXPECT_EQ(encoded(again), cdr) << M::type_name << ", seed " << seed;
    }
  });
}

TEST(Cdr, RejectsAMessageCutOffAnywhere) {
  for_each_type([]<Message M>(const M& /*type*/) {
    for (unsigned seed{0}; seed < 3; ++seed) {
      M message;
      RandomFiller{seed}.fill(message);
      const Bytes cdr{encoded(message)};
      for (std::size_t size{0}; size < cdr.size(); ++size) {
        EXPECT_THAT(error_text_of<M>({cdr.begin(), cdr.begin() + static_cast<std::ptrdiff_t>(size)}),
                    testing::HasSubstr(std::string{M::type_name}))
            << size << " of " << cdr.size();
      }
    }
  });
}

TEST(Cdr, SaysWhichFieldIsWrong) {
  using testing::AllOf;
  using testing::HasSubstr;
  EXPECT_THAT(error_text_of<std_msgs::Header>(bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 'a'})),
              AllOf(HasSubstr("std_msgs/msg/Header"), HasSubstr("\"frame_id\" claims 4294967295 elements"),
                    HasSubstr("1 bytes are left")));
  EXPECT_THAT(error_text_of<std_msgs::Header>(bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 'a'})),
              HasSubstr("\"frame_id\" is a text without a 0 at its end"));
  EXPECT_THAT(error_text_of<Sizes>(bytes({0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2})),
              HasSubstr("\"d\" is neither true nor false"));
}

TEST(Cdr, TakesItsOwnEncodingOnly) {
  const std::string says{"plain little-endian CDR"};
  EXPECT_THAT(error_text_of<std_msgs::Header>(bytes({0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 0})),
              testing::HasSubstr(says));
  EXPECT_THAT(error_text_of<std_msgs::Header>(bytes({0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0})),
              testing::HasSubstr(says));
  EXPECT_THAT(error_text_of<std_msgs::Header>({}), testing::HasSubstr(says));
}

// DDS pads messages to a multiple of four; longer ones are invalid.
TEST(Cdr, TakesThreeBytesMoreAtTheEnd) {
  Bytes cdr{encoded(std_msgs::Header{{1, 2}, "odom"})};
  cdr.resize(cdr.size() + 3);
  EXPECT_EQ(error_text_of<std_msgs::Header>(cdr), "");
  cdr.resize(cdr.size() + 1);
  EXPECT_THAT(error_text_of<std_msgs::Header>(cdr), testing::HasSubstr("4 bytes are left over"));
}

TEST(Cdr, TakesAnEmptyTextWithoutItsZero) {
  EXPECT_EQ(error_text_of<std_msgs::Header>(bytes({0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0})), "");
}

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
