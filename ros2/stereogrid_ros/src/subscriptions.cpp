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

void add_depth(stereogrid::capture::CameraPair& pair, stereogrid::Image<float> depth_m, const char* name,
               Clock::time_point at) {
  const stereogrid::Rig& rig{pair.rig()};
  pair.add_depth(stereogrid::io::fit_depth(std::move(depth_m), rig.width_px, rig.height_px, name), at);
}

}  // namespace

template <class Message, class Callback>
void StereoGridNode::subscribe(const std::string& topic, Callback callback) {
  subscriptions_.push_back(create_subscription<Message>(topic, rclcpp::SensorDataQoS{}, std::move(callback)));
}

void StereoGridNode::subscribe_all() {
  using sensor_msgs::msg::CameraInfo;
  const std::string images{settings_.are_rectified ? "/image_rect" : "/image_raw"};
  const auto add_image = [](Side side, const char* name) {
    return [=](Pair& pair, const RosImage& image, auto at) {
      pair.add(side, stereogrid::io::decode_ros_image(image, name), at);
    };
  };
  subscribe<CameraInfo>("left/camera_info", [this](const CameraInfo& info) { take_info(Side::left, info); });
  subscribe_images(Side::left, "left" + images, settings_.image_transport, add_image(Side::left, "left image"));
  if (settings_.input == "depth") {
    subscribe_images(Side::right, "depth" + images, settings_.depth_image_transport,
                     [](Pair& pair, const RosImage& image, auto at) {
                       constexpr const char* name{"depth image"};
                       add_depth(pair, stereogrid::io::decode_ros_depth(image, name), name, at);
                     });
  } else if (settings_.input == "disparity") {
    using stereo_msgs::msg::DisparityImage;
    subscribe<DisparityImage>("disparity", [this](const DisparityImage& disparity) { take_disparity(disparity); });
  } else {
    subscribe<CameraInfo>("right/camera_info", [this](const CameraInfo& info) { take_info(Side::right, info); });
    subscribe_images(Side::right, "right" + images, settings_.image_transport, add_image(Side::right, "right image"));
  }
}

void StereoGridNode::subscribe_images(Side side, const std::string& topic, const std::string& transport,
                                      const AddImage& add) {
  const auto receive = [this, side, add](const auto& message) {
    take(side, message.header.stamp,
         [&](Pair& pair, auto at) { add(pair, stereogrid::io::ros_image_of(message), at); });
  };
  using sensor_msgs::msg::CompressedImage;
  using sensor_msgs::msg::Image;
  if (transport == "raw") {
    subscribe<Image>(topic, [receive](const Image& message) { receive(message); });
  } else {
    subscribe<CompressedImage>(topic + "/" + transport,
                               [receive](const CompressedImage& message) { receive(message); });
  }
}

void StereoGridNode::take_info(Side side, const sensor_msgs::msg::CameraInfo& info) {
  const std::scoped_lock lock{mutex_};
  if (pair_) return;
  infos_.at(index_of(side)) = info;
  changed_.notify_all();
}

void StereoGridNode::take_disparity(const stereo_msgs::msg::DisparityImage& disparity) {
  if (baseline_m_ == 0 && disparity.t != 0) {
    const std::scoped_lock lock{mutex_};
    baseline_m_ = std::abs(disparity.t);
    changed_.notify_all();
  }
  take(Side::right, disparity.header.stamp, [&](Pair& pair, auto at) {
    constexpr const char* name{"disparity image"};
    const auto disparities{stereogrid::io::ros_disparities_of(disparity)};
    add_depth(pair, stereogrid::io::decode_ros_disparities(disparities, name), name, at);
  });
}

void StereoGridNode::take(Side side, const builtin_interfaces::msg::Time& stamp,
                          const std::function<void(Pair&, Clock::time_point)>& add) {
  const std::int64_t stamp_ns{rclcpp::Time{stamp}.nanoseconds()};
  std::shared_ptr<Pair> pair;
  {
    const std::scoped_lock lock{mutex_};
    if (!pair_) return;
    std::int64_t& newest_ns{newest_ns_.at(index_of(side))};
    if (stamp_ns + step_back_ns < newest_ns) {
      RCLCPP_INFO(get_logger(), "the stamps of the images step back: restart");
      newest_ns_.fill(stamp_ns);
      pair_ = std::make_shared<Pair>(calibration_, pairing());
    }
    newest_ns = std::max(newest_ns, stamp_ns);
    pair = pair_;
  }
  try {
    add(*pair, Clock::time_point{std::chrono::nanoseconds{stamp_ns - clock_ns_}});
  } catch (const InputError& error) {
    pair->add_unusable();
    warn(error.what());
  }
}

}  // namespace stereogrid_ros
