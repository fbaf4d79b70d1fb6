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

/// A camera's calibration, and the topic that it came from.
struct Info {
  CameraInfo message;
  std::string name;   ///< of the bag and the topic, for complaints
  std::string topic;  ///< for people

  [[noreturn]] void fail(const std::string& what) const { throw InputError{name, what, give_file}; }
};

Info info_of(const mcap::Bag& bag, const std::string& name, const std::string& images) {
  const std::string topic_name{info_topic_of(*find_topic(bag.topics(), images))};
  Info info{{}, name + ", " + io::printable(topic_name), io::printable(topic_name)};
  const mcap::Topic* const topic{find_topic(bag.topics(), topic_name)};
  if (topic == nullptr || topic->type != CameraInfo::type_name) {
    info.fail(fmt::format("there is no CameraInfo for {}.", io::printable(images)));
  }
  const auto cursor{bag.messages({.topics = {topic_name}})};
  const mcap::Message* const first{cursor->next()};
  if (first == nullptr) info.fail("no message can be read.");
  messages::decode(first->data, info.message);
  return info;
}

io::RosCamera camera_of(const Info& info, int width_px, int height_px) {
  const CameraInfo& message{info.message};
  if (message.k[0] == 0) info.fail("the camera is not calibrated: K[0] is 0.");
  if (message.binning_x > 1 || message.binning_y > 1 || message.roi.x_offset != 0 || message.roi.y_offset != 0) {
    info.fail("the images are a part of the camera's (binning, roi), which is not read.");
  }
  if (message.width != static_cast<std::uint32_t>(width_px) ||
      message.height != static_cast<std::uint32_t>(height_px)) {
    info.fail(fmt::format("the CameraInfo is for {}×{} px, but the images have {}×{}.", message.width, message.height,
                          width_px, height_px));
  }
  io::RosCamera camera{info.name, width_px,  height_px, message.distortion_model,
                       message.d, message.k, message.r, message.p};
  // simulators leave it out where there is none; without numbers a fisheye lens still is one
  if (camera.d.empty() && camera.distortion_model != "equidistant") {
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

}  // namespace

io::Calibration calibration_of(const mcap::Bag& bag, const std::string& name, const ImageTopics& topics, int width_px,
                               int height_px) {
  const Info left{info_of(bag, name, topics.left)};
  const Info right{info_of(bag, name, topics.right)};
  const bool are_rectified{is_rectified(*find_topic(bag.topics(), topics.left)) &&
                           is_rectified(*find_topic(bag.topics(), topics.right))};
  io::Calibration calibration{
      io::ros_calibration(camera_of(left, width_px, height_px), camera_of(right, width_px, height_px), are_rectified)};
  calibration.kind = fmt::format("CameraInfo of {} and {}", left.topic, right.topic);
  return calibration;
}

}  // namespace stereogrid::app
