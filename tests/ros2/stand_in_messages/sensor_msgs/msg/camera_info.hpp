// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <std_msgs/msg/header.hpp>

namespace sensor_msgs::msg {

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
