// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "stereogrid/messages/std_msgs.hpp"

namespace stereogrid::messages::sensor_msgs {

/// px; all 0: the whole image.
struct RegionOfInterest {
  STEREOGRID_MESSAGE("sensor_msgs/msg/RegionOfInterest", x_offset, y_offset, height, width, do_rectify);

  std::uint32_t x_offset{0};
  std::uint32_t y_offset{0};
  std::uint32_t height{0};
  std::uint32_t width{0};
  bool do_rectify{false};
};

struct Image {
  STEREOGRID_MESSAGE("sensor_msgs/msg/Image", header, height, width, encoding, is_bigendian, step, data);

  std_msgs::Header header;
  std::uint32_t height{0};
  std::uint32_t width{0};
  std::string encoding;  ///< mono8, bgr8, 32FC1, …
  std::uint8_t is_bigendian{0};
  std::uint32_t step{0};  ///< bytes from a row to the next
  std::vector<std::uint8_t> data;
};

struct CompressedImage {
  STEREOGRID_MESSAGE("sensor_msgs/msg/CompressedImage", header, format, data);

  std_msgs::Header header;
  std::string format;  ///< jpeg, png
  std::vector<std::uint8_t> data;
};

/// Matrices are row-major.
struct CameraInfo {
  STEREOGRID_MESSAGE("sensor_msgs/msg/CameraInfo", header, height, width, distortion_model, d, k, r, p, binning_x,
                     binning_y, roi);

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
};

struct PointField {
  STEREOGRID_MESSAGE("sensor_msgs/msg/PointField", name, offset, datatype, count);

  std::string name;
  std::uint32_t offset{0};   ///< bytes, within a point
  std::uint8_t datatype{0};  ///< 2: uint8, 7: float32
  std::uint32_t count{0};
};

struct PointCloud2 {
  STEREOGRID_MESSAGE("sensor_msgs/msg/PointCloud2", header, height, width, fields, is_bigendian, point_step, row_step,
                     data, is_dense);

  std_msgs::Header header;
  std::uint32_t height{0};  ///< 1: no image
  std::uint32_t width{0};
  std::vector<PointField> fields;
  bool is_bigendian{false};
  std::uint32_t point_step{0};  ///< bytes
  std::uint32_t row_step{0};    ///< bytes
  std::vector<std::uint8_t> data;
  bool is_dense{false};  ///< no coordinate is NaN
};

struct LaserScan {
  STEREOGRID_MESSAGE("sensor_msgs/msg/LaserScan", header, angle_min, angle_max, angle_increment, time_increment,
                     scan_time, range_min, range_max, ranges, intensities);

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
};

}  // namespace stereogrid::messages::sensor_msgs

namespace stereogrid::messages::stereo_msgs {

struct DisparityImage {
  STEREOGRID_MESSAGE("stereo_msgs/msg/DisparityImage", header, image, f, t, valid_window, min_disparity, max_disparity,
                     delta_d);

  std_msgs::Header header;
  sensor_msgs::Image image;  ///< 32FC1, px; below min_disparity: none
  float f{0};                ///< px
  float t{0};                ///< m, baseline
  sensor_msgs::RegionOfInterest valid_window;
  float min_disparity{0};  ///< px
  float max_disparity{0};  ///< px
  float delta_d{0};        ///< px, smallest step
};

}  // namespace stereogrid::messages::stereo_msgs
