// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::sensor_msgs {

/// px; all 0: the whole image.
struct RegionOfInterest {
  static constexpr std::string_view type_name{"sensor_msgs/msg/RegionOfInterest"};

  std::uint32_t x_offset{0};
  std::uint32_t y_offset{0};
  std::uint32_t height{0};
  std::uint32_t width{0};
  bool do_rectify{false};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("x_offset", self.x_offset);
    visit("y_offset", self.y_offset);
    visit("height", self.height);
    visit("width", self.width);
    visit("do_rectify", self.do_rectify);
  }
};

struct Image {
  static constexpr std::string_view type_name{"sensor_msgs/msg/Image"};

  std_msgs::Header header;
  std::uint32_t height{0};
  std::uint32_t width{0};
  std::string encoding;  ///< mono8, bgr8, 32FC1, …
  std::uint8_t is_bigendian{0};
  std::uint32_t step{0};  ///< bytes from a row to the next
  std::vector<std::uint8_t> data;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("encoding", self.encoding);
    visit("is_bigendian", self.is_bigendian);
    visit("step", self.step);
    visit("data", self.data);
  }
};

struct CompressedImage {
  static constexpr std::string_view type_name{"sensor_msgs/msg/CompressedImage"};

  std_msgs::Header header;
  std::string format;  ///< jpeg, png
  std::vector<std::uint8_t> data;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("format", self.format);
    visit("data", self.data);
  }
};

/// Matrices are row-major.
struct CameraInfo {
  static constexpr std::string_view type_name{"sensor_msgs/msg/CameraInfo"};

  std_msgs::Header header;
  std::uint32_t height{0};  ///< size of the calibration's images, px
  std::uint32_t width{0};
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};  ///< all 0: not calibrated
  std::array<double, 9> r{};
  std::array<double, 12> p{};  ///< right camera: p[3] = −focal length · baseline
  std::uint32_t binning_x{0};
  std::uint32_t binning_y{0};
  RegionOfInterest roi;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("distortion_model", self.distortion_model);
    visit("d", self.d);
    visit("k", self.k);
    visit("r", self.r);
    visit("p", self.p);
    visit("binning_x", self.binning_x);
    visit("binning_y", self.binning_y);
    visit("roi", self.roi);
  }
};

struct PointField {
  static constexpr std::string_view type_name{"sensor_msgs/msg/PointField"};

  std::string name;
  std::uint32_t offset{0};   ///< bytes, within a point
  std::uint8_t datatype{0};  ///< 2: uint8, 7: float32
  std::uint32_t count{0};

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("name", self.name);
    visit("offset", self.offset);
    visit("datatype", self.datatype);
    visit("count", self.count);
  }
};

struct PointCloud2 {
  static constexpr std::string_view type_name{"sensor_msgs/msg/PointCloud2"};

  std_msgs::Header header;
  std::uint32_t height{0};  ///< 1: no image
  std::uint32_t width{0};
  std::vector<PointField> fields;
  bool is_bigendian{false};
  std::uint32_t point_step{0};  ///< bytes
  std::uint32_t row_step{0};    ///< bytes
  std::vector<std::uint8_t> data;
  bool is_dense{false};  ///< no coordinate is NaN

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("height", self.height);
    visit("width", self.width);
    visit("fields", self.fields);
    visit("is_bigendian", self.is_bigendian);
    visit("point_step", self.point_step);
    visit("row_step", self.row_step);
    visit("data", self.data);
    visit("is_dense", self.is_dense);
  }
};

struct LaserScan {
  static constexpr std::string_view type_name{"sensor_msgs/msg/LaserScan"};

  std_msgs::Header header;
  float angle_min{0};  ///< rad, counter-clockwise, 0 along x
  float angle_max{0};  ///< angle of the last beam, rad
  float angle_increment{0};
  float time_increment{0};    ///< s
  float scan_time{0};         ///< s
  float range_min{0};         ///< m
  float range_max{0};         ///< m
  std::vector<float> ranges;  ///< m; +inf: free; NaN: unknown (REP 117)
  std::vector<float> intensities;

  template <class Self, class Visitor>
  static void visit_fields(Self& self, Visitor&& visit) {
    visit("header", self.header);
    visit("angle_min", self.angle_min);
    visit("angle_max", self.angle_max);
    visit("angle_increment", self.angle_increment);
    visit("time_increment", self.time_increment);
    visit("scan_time", self.scan_time);
    visit("range_min", self.range_min);
    visit("range_max", self.range_max);
    visit("ranges", self.ranges);
    visit("intensities", self.intensities);
  }
};

}  // namespace stereogrid::messages::sensor_msgs
