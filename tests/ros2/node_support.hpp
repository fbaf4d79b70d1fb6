// SPDX-License-Identifier: Apache-2.0
//
// The component of ROS 2 against stand-ins of rclcpp and tf2_ros: what it does with messages, not how they come.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "settings.hpp"
#include "stereo_grid_node.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/scenes/scene.hpp"

namespace stereogrid_ros::testing {

using namespace std::chrono_literals;

constexpr std::int64_t second_ns{1'000'000'000};
constexpr std::int64_t begin_ns{1'700'000'000 * second_ns};

inline std_msgs::msg::Header header_of(std::int64_t stamp_ns) {
  return {{static_cast<std::int32_t>(stamp_ns / second_ns), static_cast<std::uint32_t>(stamp_ns % second_ns)},
          "camera"};
}

inline sensor_msgs::msg::Image message_of(const stereogrid::Image<std::uint8_t>& image, std::int64_t stamp_ns) {
  sensor_msgs::msg::Image message;
  message.header = header_of(stamp_ns);
  message.width = static_cast<std::uint32_t>(image.width());
  message.height = static_cast<std::uint32_t>(image.height());
  message.step = message.width;
  message.encoding = "mono8";
  message.data.assign(image.data(), image.data() + image.width() * image.height());
  return message;
}

inline sensor_msgs::msg::CameraInfo info_of(const stereogrid::Rig& rig, double baseline_m) {
  sensor_msgs::msg::CameraInfo info;
  info.header = header_of(begin_ns);
  info.width = static_cast<std::uint32_t>(rig.width_px);
  info.height = static_cast<std::uint32_t>(rig.height_px);
  info.distortion_model = "plumb_bob";
  info.d.resize(5);
  info.k = {rig.focal_px, 0, rig.cx_px, 0, rig.focal_px, rig.cy_px, 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {rig.focal_px, 0, rig.cx_px, -rig.focal_px * baseline_m, 0, rig.focal_px, rig.cy_px, 0, 0, 0, 1, 0};
  return info;
}

template <class Message>
void hand_in(const std::string& topic, const Message& message) {
  std::function<void(const void*)> subscriber;
  {
    const std::scoped_lock lock{stand_in::world().mutex};
    subscriber = stand_in::world().subscribers.at(topic);
  }
  subscriber(&message);
}

inline std::vector<std::vector<std::uint8_t>> published(const std::string& topic) {
  const std::scoped_lock lock{stand_in::world().mutex};
  return stand_in::world().published[topic].messages;
}

inline std::vector<std::string> logged() {
  const std::scoped_lock lock{stand_in::world().mutex};
  return stand_in::world().log;
}

/// Until it is so, or half a minute has passed.
template <class Condition>
bool wait_for(Condition condition) {
  for (const auto end{std::chrono::steady_clock::now() + 30s}; std::chrono::steady_clock::now() < end;) {
    if (condition()) return true;
    std::this_thread::sleep_for(2ms);
  }
  return condition();
}

/// Keeps what a pipeline of ours sends, by topic.
class Kept final : public stereogrid::messages::Sink {
 public:
  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    topics_.push_back(channel.topic);
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }
  [[nodiscard]] bool wants(std::uint32_t) const override { return true; }
  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    const auto* const bytes{reinterpret_cast<const std::uint8_t*>(cdr.data())};
    messages[topics_.at(channel)].emplace_back(bytes, bytes + cdr.size());
  }

  std::map<std::string, std::vector<std::vector<std::uint8_t>>> messages;

 private:
  std::vector<std::string> topics_;
};

/// Image of one value everywhere.
template <class T>
sensor_msgs::msg::Image image_of(const char* encoding, int width_px, int height_px, T value, std::int64_t stamp_ns) {
  sensor_msgs::msg::Image image{message_of(stereogrid::Image<std::uint8_t>(width_px, height_px), stamp_ns)};
  const std::vector<T> all(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px), value);
  image.encoding = encoding;
  image.step = image.width * sizeof(T);
  image.data.resize(all.size() * sizeof(T));
  std::memcpy(image.data.data(), all.data(), image.data.size());
  return image;
}

class Ros2Node : public ::testing::Test {
 protected:
  void SetUp() override {
    stand_in::World& world{stand_in::world()};
    world.published.clear();
    world.subscribers.clear();
    world.missing_packages.clear();
    world.log.clear();
    world.is_shut_down = false;
    world.publishing_fails = false;
    stand_in::lookup() = [this](const std::string& target, const std::string&, std::int64_t stamp_ns) {
      return target == "base_footprint" ? mounting_ : way(stamp_ns);
    };
  }

  void start(std::vector<rclcpp::Parameter> parameters) {
    parameters.emplace_back("device", std::string{"cpu"});
    node_.emplace(rclcpp::NodeOptions{}.parameter_overrides(parameters));
  }
  /// As the node reads it, whose baseline is a quotient.
  [[nodiscard]] stereogrid::Rig read_rig() const {
    const auto camera{[&](double baseline_m) { return camera_of(info_of(scene_.rig(), baseline_m), "camera"); }};
    stereogrid::Rig rig{stereogrid::io::ros_calibration(camera(0), camera(scene_.rig().baseline_m), true).rig};
    set_extrinsics(rig, *mounting_);
    return rig;
  }
  void hand_in_infos() {
    hand_in("left/camera_info", info_of(scene_.rig(), 0));
    hand_in("right/camera_info", info_of(scene_.rig(), scene_.rig().baseline_m));
  }
  /// Publishes frames repeatedly until the first grid: another thread opens the pair, and earlier images are dropped.
  void hand_in_frames(std::size_t count) {
    for (std::size_t i{0}; i < count; ++i) {
      const std::size_t before{published(grids).size()};
      for (int attempt{0}; attempt < 100 && published(grids).size() == before; ++attempt) {
        hand_in_pair(i);
        if (wait_for_grid(before)) break;
      }
    }
  }
  void hand_in_pair(std::size_t i) {
    const stereogrid::StereoFrame frame{scene_.load(i)};
    hand_in("left/image_rect", message_of(frame.left, begin_ns + frame.stamp_ns));
    hand_in("right/image_rect", message_of(frame.right, begin_ns + frame.stamp_ns));
  }
  static bool wait_for_grid(std::size_t before) {
    for (int i{0}; i < 200; ++i) {
      if (published(grids).size() > before) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }

  [[nodiscard]] static std::optional<geometry_msgs::msg::Transform> way(std::int64_t stamp_ns) {
    const double x_m{static_cast<double>(stamp_ns - begin_ns) / 1e9};  // 1 m/s ahead
    return geometry_msgs::msg::Transform{{x_m, 5, 1}, {-0.5, 0.5, -0.5, 0.5}};
  }

  static constexpr const char* grids{"/stereo_grid/occupancy_grid"};
  stereogrid::scenes::Scene scene_{stereogrid::scenes::parse_scene("scene:street?width=192&height=128&frames=6")};
  // level: z ahead becomes x, x to the right becomes −y
  std::optional<geometry_msgs::msg::Transform> mounting_{
      geometry_msgs::msg::Transform{{0.5, 0, scene_.rig().camera_height_m}, {-0.5, 0.5, -0.5, 0.5}}};
  std::optional<StereoGridNode> node_;
};

}  // namespace stereogrid_ros::testing
