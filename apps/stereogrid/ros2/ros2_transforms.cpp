// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "ros2/ros2_transforms.hpp"

#include <spdlog/spdlog.h>

#include <chrono>
#include <thread>

#include "ros2/waiting.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/std_msgs.hpp"
#include "stereogrid/messages/tf2_msgs.hpp"

namespace stereogrid::app {
namespace {

using namespace std::chrono_literals;
using messages::tf2_msgs::TFMessage;

constexpr std::size_t dynamic_depth{100};  // as tf2_ros has it
constexpr std::size_t static_depth{100};
constexpr auto image_patience{1s};
constexpr auto static_patience{100ms};  // they have been received since before the images were found
constexpr double degrees{180 / 3.14159265358979323846};

}  // namespace

std::shared_ptr<TransformBuffer> subscribe_transforms(dds::Node& node) {
  auto buffer{std::make_shared<TransformBuffer>()};
  for (const bool is_static : {false, true}) {
    node.subscribe(
        is_static ? "/tf_static" : "/tf", std::string{TFMessage::type_name}, is_static ? static_depth : dynamic_depth,
        [buffer, is_static](std::span<const std::byte> cdr) {
          TFMessage message;
          messages::decode(cdr, message);
          buffer->add(message, is_static);
        },
        is_static);
  }
  return buffer;
}

std::string frame_of_images(dds::Node& node, const mcap::Topic& images) {
  NewestMessages newest{node};
  newest.add(images);
  const auto end{std::chrono::steady_clock::now() + image_patience};
  for (; std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(10ms)) {
    const auto cdr{newest.of(images.name)};
    if (!cdr) continue;
    messages::std_msgs::Header header;
    messages::CdrReader reader{*cdr, messages::std_msgs::Header::type_name};
    reader("header", header);
    return header.frame_id;
  }
  return "";
}

bool are_connected(TransformBuffer& transforms, const std::string& target, const std::string& source) {
  try {
    static_cast<void>(transforms.newest(target, source, static_patience));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool set_extrinsics_of_tf(Rig& rig, TransformBuffer& transforms, const std::string& camera_frame) {
  if (camera_frame.empty() || !are_connected(transforms, "base_link", camera_frame)) return false;
  // base_link may be above the road
  const char* const base{are_connected(transforms, "base_footprint", camera_frame) ? "base_footprint" : "base_link"};
  if (!set_extrinsics(rig, transforms.newest(base, camera_frame, 0ms))) {
    spdlog::warn("TF: {} is not above z = 0 of {}, or points straight up or down; its extrinsics are not used",
                 io::printable(camera_frame, 60), base);
    return false;
  }
  spdlog::info("extrinsics of TF ({} → {}), checked against the road: height {:.2f} m, pitch {:.1f}°, roll {:.1f}°",
               base, io::printable(camera_frame, 60), rig.camera_height_m, rig.camera_pitch_rad * degrees,
               rig.camera_roll_rad * degrees);
  return true;
}

}  // namespace stereogrid::app
