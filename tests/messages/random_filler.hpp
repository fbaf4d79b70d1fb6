// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "stereogrid/messages/foxglove_msgs.hpp"
#include "stereogrid/messages/geometry_msgs.hpp"
#include "stereogrid/messages/message.hpp"
#include "stereogrid/messages/nav_msgs.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/messages/vision_msgs.hpp"
#include "stereogrid/messages/visualization_msgs.hpp"

namespace stereogrid::messages::test {

/// Fills messages with any values: ends of ranges, no numbers, empty texts and arrays among them.
class RandomFiller {
 public:
  explicit RandomFiller(unsigned seed) : random_{seed} {}

  template <class T>
  void operator()(std::string_view /*name*/, T& field) {
    fill(field);
  }
  template <Message M>
  void fill(M& message) {
    message.visit_fields(*this);
  }

 private:
  std::size_t below(std::size_t end) { return std::uniform_int_distribution<std::size_t>{0, end - 1}(random_); }

  void fill(bool& flag) { flag = below(2) == 1; }
  void fill(std::byte& byte) { byte = static_cast<std::byte>(below(256)); }
  template <Primitive T>
  void fill(T& number) {
    using Limits = std::numeric_limits<T>;
    if constexpr (std::is_floating_point_v<T>) {
      const std::array<T, 6> special{
          0, Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(), Limits::denorm_min(), Limits::lowest()};
      number = below(4) == 0 ? special[below(special.size())] : std::normal_distribution<T>{0, 1000}(random_);
    } else {
      number = below(4) == 0 ? Limits::max() : below(4) == 0 ? Limits::min() : static_cast<T>(random_());
    }
  }
  void fill(std::string& text) {
    text.clear();
    for (std::size_t rest{below(12)}; rest > 0; --rest) text += static_cast<char>('a' + below(26));
  }
  template <class T>
  void fill(std::vector<T>& elements) {
    elements.resize(below(std::is_arithmetic_v<T> ? 40 : 4));
    for (T& element : elements) fill(element);
  }
  template <class T, std::size_t n>
  void fill(std::array<T, n>& elements) {
    for (T& element : elements) fill(element);
  }

  std::mt19937 random_;
};

/// Published types; all others are parts of them.
using Types = std::tuple<nav_msgs::OccupancyGrid, nav_msgs::Odometry, grid_map_msgs::GridMap, foxglove_msgs::Grid,
                         nav2_dynamic_msgs::ObstacleArray, vision_msgs::Detection3DArray,
                         visualization_msgs::MarkerArray, stereo_msgs::DisparityImage, sensor_msgs::PointCloud2,
                         sensor_msgs::CompressedImage, sensor_msgs::LaserScan, sensor_msgs::Image,
                         sensor_msgs::CameraInfo, tf2_msgs::TFMessage, diagnostic_msgs::DiagnosticArray>;

/// Calls `work` with a message of each type.
template <class Work>
void for_each_type(Work&& work) {
  std::apply([&](const auto&... message) { (work(message), ...); }, Types{});
}

}  // namespace stereogrid::messages::test
