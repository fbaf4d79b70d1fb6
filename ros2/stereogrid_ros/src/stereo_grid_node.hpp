// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Copyright 2026 The stereogrid authors
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.
#pragma once

#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>  // NOLINT(build/include_order): unknown to cpplint
#include <string>
#include <thread>
#include <vector>

#include <rclcpp/rclcpp.hpp>
#include <rclcpp_lifecycle/lifecycle_node.hpp>
#include <sensor_msgs/msg/camera_info.hpp>
#include <sensor_msgs/msg/compressed_image.hpp>
#include <sensor_msgs/msg/image.hpp>
#include <stereo_msgs/msg/disparity_image.hpp>

#include "settings.hpp"
#include "stereogrid/capture/camera_pair.hpp"
#include "stereogrid/capture/frame_loop.hpp"
#include "stereogrid/capture/live_source.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/messages/frame_messages.hpp"
#include "stereogrid/messages/sink.hpp"
#include "stereogrid/odometry.hpp"

namespace stereogrid_ros {

/// Publishes encoded messages. Topics whose message package is not installed are left out with a warning.
class PublisherSink final : public stereogrid::messages::Sink {
 public:
  /// `node` must outlive this object.
  explicit PublisherSink(rclcpp_lifecycle::LifecycleNode& node) : node_{node} {}

  std::uint32_t add(const stereogrid::messages::Channel& channel) override {
    const rclcpp::QoS qos{channel.latched ? rclcpp::QoS{1}.transient_local() : rclcpp::QoS{10}};
    Topic& topic{topics_.emplace_back(Topic{nullptr, channel.latched})};
    try {
      topic.publisher = node_.create_generic_publisher(channel.topic, std::string{channel.type}, qos);
    } catch (const std::exception& error) {
      RCLCPP_WARN(node_.get_logger(), "%s is not published: %s", channel.topic.c_str(), error.what());
    }
    return static_cast<std::uint32_t>(topics_.size() - 1);
  }

  [[nodiscard]] bool wants(std::uint32_t channel) const override {
    const Topic& topic{topics_.at(channel)};
    return topic.publisher && (topic.latched || topic.publisher->get_subscription_count() > 0);
  }

  void send(std::uint32_t channel, std::int64_t, std::span<const std::byte> cdr) override {
    if (!topics_.at(channel).publisher) return;
    message_.reserve(cdr.size());
    rcl_serialized_message_t& bytes{message_.get_rcl_serialized_message()};
    std::memcpy(bytes.buffer, cdr.data(), cdr.size());
    bytes.buffer_length = cdr.size();
    topics_.at(channel).publisher->publish(message_);
  }

  /// Removes all publishers, with their latched messages.
  void clear() { topics_.clear(); }

 private:
  struct Topic {
    rclcpp::GenericPublisher::SharedPtr publisher;  // empty: left out
    bool latched;
  };

  rclcpp_lifecycle::LifecycleNode& node_;
  std::vector<Topic> topics_;
  rclcpp::SerializedMessage message_;  // its memory is reused
};

/// Subscribes to left/image_rect and left/camera_info, and to right/image_rect and right/camera_info, depth/image_rect
/// or disparity, of several cameras below their namespaces; publishes grids while active.
class StereoGridNode final : public rclcpp_lifecycle::LifecycleNode {
 public:
  /// Active afterwards, unless the parameter autostart is false. Throws stereogrid::ConfigError: invalid parameters,
  /// with autostart; without, on_configure() fails.
  explicit StereoGridNode(const rclcpp::NodeOptions& options = rclcpp::NodeOptions{});
  ~StereoGridNode() override;

  CallbackReturn on_configure(const rclcpp_lifecycle::State& previous) override;
  CallbackReturn on_activate(const rclcpp_lifecycle::State& previous) override;
  CallbackReturn on_deactivate(const rclcpp_lifecycle::State& previous) override;
  CallbackReturn on_cleanup(const rclcpp_lifecycle::State& previous) override;
  CallbackReturn on_shutdown(const rclcpp_lifecycle::State& previous) override;

  /// True after an error that has ended the thread of the active node; other nodes of the process are not affected.
  [[nodiscard]] bool has_failed() const { return has_failed_; }
  /// Called by that thread after such an error.
  void set_failure_handler(std::function<void()> handler);

 private:
  using Side = stereogrid::capture::Side;
  using Pair = stereogrid::capture::CameraPair;
  using PreparedFrame = stereogrid::capture::PreparedFrame;
  using AddImage = std::function<void(Pair&, const stereogrid::io::RosImage&, stereogrid::capture::Clock::time_point)>;
  class Frames;
  class CameraSource;

  /// A stereo pair, or a camera with depth, which the node's mutex guards.
  struct Camera {
    std::string prefix;  ///< namespace of its topics, with a slash behind; "": the node's
    std::array<std::optional<sensor_msgs::msg::CameraInfo>, 2> infos{};  ///< not yet used
    std::atomic<double> baseline_m{0};  ///< baseline of the disparities; 0: none so far
    std::array<std::int64_t, 2> newest_ns{};
    stereogrid::io::Calibration calibration{};
    std::shared_ptr<Pair> pair{};  ///< replaced after time has stepped back
    std::string frame{};           ///< left camera's
  };

  template <class Message, class Callback>
  void subscribe(const std::string& topic, Callback callback);
  void subscribe_all(const std::shared_ptr<Camera>& camera);
  /// Images of a transport of image_transport, which `add` adds to the pair.
  void subscribe_images(const std::shared_ptr<Camera>& camera, Side side, const std::string& topic,
                        const std::string& transport, const AddImage& add);
  void stop();
  /// Thresholds are set; other parameters of configure are refused.
  [[nodiscard]] rcl_interfaces::msg::SetParametersResult set(const std::vector<rclcpp::Parameter>& parameters);
  void receive_info(Camera& camera, Side side, const sensor_msgs::msg::CameraInfo& info);
  void receive_disparity(Camera& camera, const stereo_msgs::msg::DisparityImage& disparity);
  /// Adds an image by `add` to the pair, if there is one.
  void receive(Camera& camera, Side side, const builtin_interfaces::msg::Time& stamp,
               const std::function<void(Pair&, stereogrid::capture::Clock::time_point)>& add);
  /// Logs a warning; the same text, numbers aside, at most once a minute.
  void warn(const std::string& text);

  [[nodiscard]] std::function<void()> failure_handler();

  // called by the thread
  void work();
  [[nodiscard]] bool open_pair(Camera& camera);
  [[nodiscard]] bool has_infos(const Camera& camera) const;
  /// `right`: empty unless the input is stereo.
  [[nodiscard]] stereogrid::io::Calibration calibration_of(
      const Camera& camera, const sensor_msgs::msg::CameraInfo& left,
      const std::optional<sensor_msgs::msg::CameraInfo>& right) const;
  [[nodiscard]] std::shared_ptr<Pair> current_pair(const Camera& camera);
  [[nodiscard]] stereogrid::capture::PairingOptions pairing() const;
  [[nodiscard]] Thresholds thresholds();
  void set_extrinsics_from_tf(stereogrid::Rig& rig, const std::string& camera_frame);
  [[nodiscard]] geometry_msgs::msg::Transform look_up(const std::string& target, const std::string& source,
                                                      const rclcpp::Time& instant);
  void go_on();

  Settings settings_;  // read by the last on_configure()
  PublisherSink sink_{*this};
  std::optional<tf2_ros::Buffer> transforms_;  // from configuration to cleanup
  std::optional<tf2_ros::TransformListener> listener_;
  std::vector<rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  rclcpp::node_interfaces::OnSetParametersCallbackHandle::SharedPtr on_set_;  // from configuration to cleanup

  std::mutex mutex_;  // guards the members up to failure_handler_
  std::condition_variable changed_;
  Thresholds thresholds_;
  std::vector<std::shared_ptr<Camera>> cameras_;  // since the last activation; callbacks have them, too
  std::map<std::string, stereogrid::capture::Clock::time_point> warned_;  // by text without numbers
  std::function<void()> failure_handler_;

  std::int64_t refused_{0};  // used by the thread only

  const std::int64_t clock_ns_;  // clock of the stamps minus the steady clock
  std::atomic<bool> is_to_stop_{false};
  std::atomic<bool> has_failed_{false};
  std::thread thread_;
};

}  // namespace stereogrid_ros
