// SPDX-License-Identifier: Apache-2.0
//
// Messages of ROS 2 that the packages in ros2/ use. CMake makes a header of each message's name that includes this one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace builtin_interfaces::msg {

struct Time {
  std::int32_t sec{0};
  std::uint32_t nanosec{0};
};

}  // namespace builtin_interfaces::msg

namespace std_msgs::msg {

struct Header {
  builtin_interfaces::msg::Time stamp;
  std::string frame_id;
};

}  // namespace std_msgs::msg

namespace geometry_msgs::msg {

struct Vector3 {
  double x{0};
  double y{0};
  double z{0};
};

struct Point {
  double x{0};
  double y{0};
  double z{0};
};

struct Quaternion {
  double x{0};
  double y{0};
  double z{0};
  double w{1};
};

struct Pose {
  Point position;
  Quaternion orientation;
};

struct Transform {
  Vector3 translation;
  Quaternion rotation;
};

struct TransformStamped {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  Transform transform;
};

}  // namespace geometry_msgs::msg

namespace nav_msgs::msg {

struct MapMetaData {
  builtin_interfaces::msg::Time map_load_time;
  float resolution{0};
  std::uint32_t width{0};
  std::uint32_t height{0};
  geometry_msgs::msg::Pose origin;
};

struct OccupancyGrid {
  std_msgs::msg::Header header;
  MapMetaData info;
  std::vector<std::int8_t> data;
};

}  // namespace nav_msgs::msg

namespace sensor_msgs::msg {

struct Image {
  std_msgs::msg::Header header;
  std::uint32_t height{0};
  std::uint32_t width{0};
  std::string encoding;
  std::uint8_t is_bigendian{0};
  std::uint32_t step{0};
  std::vector<std::uint8_t> data;
};

struct CompressedImage {
  std_msgs::msg::Header header;
  std::string format;
  std::vector<std::uint8_t> data;
};

struct RegionOfInterest {
  std::uint32_t x_offset{0};
  std::uint32_t y_offset{0};
  std::uint32_t height{0};
  std::uint32_t width{0};
  bool do_rectify{false};
};

struct CameraInfo {
  std_msgs::msg::Header header;
  std::uint32_t height{0};
  std::uint32_t width{0};
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 9> r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x{0};
  std::uint32_t binning_y{0};
  RegionOfInterest roi;
};

}  // namespace sensor_msgs::msg

namespace stereo_msgs::msg {

struct DisparityImage {
  std_msgs::msg::Header header;
  sensor_msgs::msg::Image image;
  float f{0};
  float t{0};
  float min_disparity{0};
  float max_disparity{0};
  float delta_d{0};
};

}  // namespace stereo_msgs::msg
