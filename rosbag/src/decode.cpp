// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/rosbag.hpp"

#include <cmath>

#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_image.hpp"
#include "stereogrid/messages/cdr.hpp"

namespace stereogrid::rosbag {
namespace {

namespace sensor_msgs = messages::sensor_msgs;
using messages::stereo_msgs::DisparityImage;

template <class Message>
Message decoded(std::span<const std::byte> cdr) {
  Message message;
  messages::decode(cdr, message);
  return message;
}

}  // namespace

std::int64_t ns_of(const messages::builtin_interfaces::Time& stamp) {
  return stamp.sec * std::int64_t{1'000'000'000} + stamp.nanosec;
}

std::int64_t header_stamp_ns(std::span<const std::byte> cdr) {
  messages::CdrReader reader{cdr, sensor_msgs::Image::type_name};
  messages::std_msgs::Header header;
  reader("header", header);
  return ns_of(header.stamp);
}

io::ScaledImage decode_image(std::span<const std::byte> cdr, bool is_compressed, const std::string& name) {
  if (!is_compressed) return io::decode_ros_image(io::ros_image_of(decoded<sensor_msgs::Image>(cdr)), name);
  return io::decode_ros_image(io::ros_image_of(decoded<sensor_msgs::CompressedImage>(cdr)), name);
}

Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic, const std::string& name) {
  if (topic.type == DisparityImage::type_name) {
    return io::decode_ros_disparities(io::ros_disparities_of(decoded<DisparityImage>(cdr)), name);
  }
  if (topic.type == sensor_msgs::CompressedImage::type_name) {
    return io::decode_ros_depth(io::ros_image_of(decoded<sensor_msgs::CompressedImage>(cdr)), name);
  }
  return io::decode_ros_depth(io::ros_image_of(decoded<sensor_msgs::Image>(cdr)), name);
}

double disparity_baseline_m(std::span<const std::byte> cdr) {
  const double baseline_m{std::abs(double{decoded<DisparityImage>(cdr).t})};
  return std::isfinite(baseline_m) ? baseline_m : 0;
}

double first_baseline_m(const mcap::Bag& bag, const std::string& topic) {
  const auto cursor{bag.messages({.topics = {topic}})};
  while (const mcap::Message* const message{cursor->next()}) {
    try {
      return disparity_baseline_m(message->data);
    } catch (const InputError&) {
      continue;
    }
  }
  return 0;
}

}  // namespace stereogrid::rosbag
