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
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "settings.hpp"
#include "stereo_grid_node.hpp"
#include "stereogrid/error.hpp"

namespace stereogrid_ros {
namespace {

using stereogrid::InputError;
using stereogrid::capture::Clock;
using stereogrid::io::RosImage;

constexpr std::int64_t step_back_ns{1'000'000'000};

std::size_t index_of(stereogrid::capture::Side side) {
  return side == stereogrid::capture::Side::left ? 0 : 1;
}

void add_depth(stereogrid::capture::CameraPair& pair, stereogrid::Image<float> depth_m, const std::string& name,
               Clock::time_point at) {
  const stereogrid::Rig& rig{pair.rig()};
  pair.add_depth(stereogrid::io::fit_depth(std::move(depth_m), rig.width_px, rig.height_px, name), at);
}

}  // namespace

template <class Message, class Callback>
void StereoGridNode::subscribe(const std::string& topic, Callback callback) {
  subscriptions_.push_back(create_subscription<Message>(topic, rclcpp::SensorDataQoS{}, std::move(callback)));
}

void StereoGridNode::subscribe_all(const std::shared_ptr<Camera>& camera) {
  using sensor_msgs::msg::CameraInfo;
  const std::string images{settings_.are_rectified ? "/image_rect" : "/image_raw"};
  const auto add_image = [](Side side, const std::string& name) {
    return [side, name](Pair& pair, const RosImage& image, auto at) {
      pair.add(side, stereogrid::io::decode_ros_image(image, name), at);
    };
  };
  const std::string& prefix{camera->prefix};
  subscribe<CameraInfo>(prefix + "left/camera_info",
                        [this, camera](const CameraInfo& info) { receive_info(*camera, Side::left, info); });
  subscribe_images(camera, Side::left, prefix + "left" + images, settings_.image_transport,
                   add_image(Side::left, prefix + "left image"));
  if (settings_.input == "depth") {
    subscribe_images(camera, Side::right, prefix + "depth" + images, settings_.depth_image_transport,
                     [name = prefix + "depth image"](Pair& pair, const RosImage& image, auto at) {
                       add_depth(pair, stereogrid::io::decode_ros_depth(image, name), name, at);
                     });
  } else if (settings_.input == "disparity") {
    using stereo_msgs::msg::DisparityImage;
    subscribe<DisparityImage>(prefix + "disparity", [this, camera](const DisparityImage& disparity) {
      receive_disparity(*camera, disparity);
    });
  } else {
    subscribe<CameraInfo>(prefix + "right/camera_info",
                          [this, camera](const CameraInfo& info) { receive_info(*camera, Side::right, info); });
    subscribe_images(camera, Side::right, prefix + "right" + images, settings_.image_transport,
                     add_image(Side::right, prefix + "right image"));
  }
}

void StereoGridNode::subscribe_images(const std::shared_ptr<Camera>& camera, Side side, const std::string& topic,
                                      const std::string& transport, const AddImage& add) {
  const auto add_to = [this, camera, side, add](const auto& message) {
    receive(*camera, side, message.header.stamp,
            [&](Pair& pair, auto at) { add(pair, stereogrid::io::ros_image_of(message), at); });
  };
  using sensor_msgs::msg::CompressedImage;
  using sensor_msgs::msg::Image;
  if (transport == "raw") {
    subscribe<Image>(topic, [add_to](const Image& message) { add_to(message); });
  } else {
    subscribe<CompressedImage>(topic + "/" + transport, [add_to](const CompressedImage& message) { add_to(message); });
  }
}

void StereoGridNode::receive_info(Camera& camera, Side side, const sensor_msgs::msg::CameraInfo& info) {
  const std::scoped_lock lock{mutex_};
  if (camera.pair) return;
  camera.infos.at(index_of(side)) = info;
  changed_.notify_all();
}

void StereoGridNode::receive_disparity(Camera& camera, const stereo_msgs::msg::DisparityImage& disparity) {
  if (camera.baseline_m == 0 && disparity.t != 0) {
    const std::scoped_lock lock{mutex_};
    camera.baseline_m = std::abs(disparity.t);
    changed_.notify_all();
  }
  receive(camera, Side::right, disparity.header.stamp, [&](Pair& pair, auto at) {
    const std::string name{camera.prefix + "disparity image"};
    const auto disparities{stereogrid::io::ros_disparities_of(disparity)};
    add_depth(pair, stereogrid::io::decode_ros_disparities(disparities, name), name, at);
  });
}

void StereoGridNode::receive(Camera& camera, Side side, const builtin_interfaces::msg::Time& stamp,
                             const std::function<void(Pair&, Clock::time_point)>& add) {
  const std::int64_t stamp_ns{rclcpp::Time{stamp}.nanoseconds()};
  std::shared_ptr<Pair> pair;
  {
    const std::scoped_lock lock{mutex_};
    if (!camera.pair) return;
    std::int64_t& newest_ns{camera.newest_ns.at(index_of(side))};
    if (stamp_ns + step_back_ns < newest_ns) {
      RCLCPP_INFO(get_logger(), "the stamps of the images step back: restart");
      camera.newest_ns.fill(stamp_ns);
      camera.pair = std::make_shared<Pair>(camera.calibration, pairing());
    }
    newest_ns = std::max(newest_ns, stamp_ns);
    pair = camera.pair;
  }
  try {
    add(*pair, Clock::time_point{std::chrono::nanoseconds{stamp_ns - clock_ns_}});
  } catch (const InputError& error) {
    pair->add_unusable();
    warn(error.what());
  }
}

}  // namespace stereogrid_ros
