// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "bags/calibration.hpp"

#include <fmt/format.h>

#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_camera.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"

namespace stereogrid::app {
namespace {

using messages::sensor_msgs::CameraInfo;

constexpr const char* give_file{"Give a calibration.yaml with --calibration FILE (docs/input.md)."};

[[noreturn]] void fail(const NamedInfo& info, const std::string& what) {
  throw InputError{info.name, what, give_file};
}

NamedInfo info_of(const mcap::Bag& bag, const std::string& name, const std::string& images) {
  const std::string topic_name{info_topic_of(*find_topic(bag.topics(), images))};
  NamedInfo info{{}, name + ", " + io::printable(topic_name), io::printable(topic_name)};
  const mcap::Topic* const topic{find_topic(bag.topics(), topic_name)};
  if (topic == nullptr || topic->type != CameraInfo::type_name) {
    fail(info, fmt::format("there is no CameraInfo for {}.", io::printable(images)));
  }
  const auto cursor{bag.messages({.topics = {topic_name}})};
  const mcap::Message* const first{cursor->next()};
  if (first == nullptr) fail(info, "no message can be read.");
  messages::decode(first->data, info.message);
  return info;
}

io::RosCamera camera_of(const NamedInfo& info) {
  const CameraInfo& message{info.message};
  if (message.k[0] == 0) fail(info, "the camera is not calibrated: K[0] is 0.");
  if (message.binning_x > 1 || message.binning_y > 1 || message.roi.x_offset != 0 || message.roi.y_offset != 0) {
    fail(info, "the images are a part of the camera's (binning, roi), which is not read.");
  }
  constexpr std::uint32_t largest_side_px{32768};
  if (message.width == 0 || message.height == 0 || message.width > largest_side_px ||
      message.height > largest_side_px) {
    fail(info, fmt::format("the CameraInfo is for images of {}×{} px.", message.width, message.height));
  }
  io::RosCamera camera{info.name,
                       static_cast<int>(message.width),
                       static_cast<int>(message.height),
                       message.distortion_model,
                       message.d,
                       message.k,
                       message.r,
                       message.p};
  // simulators leave it out where there is none; without numbers a fisheye lens still is one
  if (camera.d.empty() && camera.distortion_model != "equidistant") {
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

}  // namespace

io::Calibration calibration_of(const NamedInfo& left, const NamedInfo& right, bool are_rectified, int width_px,
                               int height_px) {
  io::Calibration calibration{io::ros_calibration(camera_of(left), camera_of(right), are_rectified)};
  io::fit_to_images(calibration, left.name, width_px, height_px);
  calibration.kind = fmt::format("CameraInfo of {} and {}", left.topic, right.topic);
  return calibration;
}

io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, int width_px,
                               int height_px) {
  const bool are_rectified{is_rectified(*find_topic(bag.topics(), topics.left)) &&
                           is_rectified(*find_topic(bag.topics(), topics.right))};
  const NamedInfo left{info_of(bag, name, topics.left)};
  const NamedInfo right{info_of(bag, name, topics.right)};
  return calibration_of(left, right, are_rectified, width_px, height_px);
}

}  // namespace stereogrid::app
