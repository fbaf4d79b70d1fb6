// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/depth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>
#include <string_view>
#include <utility>

#include "pixels.hpp"
#include "rvl.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/disparity_depth.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/messages/stereo_msgs.hpp"

namespace stereogrid::rosbag {
namespace {

namespace sensor_msgs = messages::sensor_msgs;

constexpr double millimetre_m{1e-3};
constexpr const char* depth_kinds{"Depth is 16UC1 in mm or 32FC1 in m; compressed, it is a PNG or RVL of these."};

/// `metres`: of a pixel.
template <class T, class Metres>
Image<float> depth_of(const cv::Mat& pixels, Metres&& metres) {
  Image<float> depth{pixels.cols, pixels.rows};
  for (int v{0}; v < pixels.rows; ++v) {
    std::transform(pixels.ptr<T>(v), pixels.ptr<T>(v) + pixels.cols, depth.row(v), [&](T value) {
      const double z_m{metres(value)};
      return std::isfinite(z_m) && z_m > 0 ? static_cast<float>(z_m) : 0.0F;
    });
  }
  return depth;
}

Image<float> depth_of_image(sensor_msgs::Image& message, const std::string& name) {
  if (message.encoding == "16UC1" || message.encoding == "mono16") {
    return depth_of<std::uint16_t>(pixels_of(message, CV_16UC1, name), [](double z) { return z * millimetre_m; });
  }
  if (message.encoding == "32FC1") {
    return depth_of<float>(pixels_of(message, CV_32FC1, name), [](double z) { return z; });
  }
  throw InputError{name, fmt::format("the encoding \"{}\" of depth is not read.", io::printable(message.encoding)),
                   depth_kinds};
}

/// compressed_depth_image_transport: a header of 12 bytes, then a PNG or RVL. Of 32FC1 they have a / z + b.
struct CompressedDepth {
  static constexpr std::size_t head_bytes{12};
  float a{0};
  float b{0};
};

Image<float> depth_of_values(const Image<std::uint16_t>& values, auto&& metres) {
  const cv::Mat view{values.height(), values.width(), CV_16UC1, const_cast<std::uint16_t*>(values.data())};
  return depth_of<std::uint16_t>(view, metres);
}

Image<float> decode_compressed_depth(const sensor_msgs::CompressedImage& message, const std::string& name) {
  std::string bytes{message.data.begin(), message.data.end()};
  const auto in_millimetres = [](double z) { return z * millimetre_m; };
  if (bytes.starts_with("\x89PNG")) return depth_of_values(io::decode_u16(name, bytes), in_millimetres);
  const auto says = [&](std::string_view word) { return message.format.find(word) != std::string::npos; };
  if (says("jpeg") || bytes.size() < CompressedDepth::head_bytes) {
    throw InputError{name, fmt::format("depth as \"{}\" is not read.", io::printable(message.format)),
                     std::string{depth_kinds} + " Set the publisher's compressedDepth format to png or rvl."};
  }
  CompressedDepth head;
  std::memcpy(&head.a, bytes.data() + 4, sizeof head.a);
  std::memcpy(&head.b, bytes.data() + 8, sizeof head.b);
  bytes.erase(0, CompressedDepth::head_bytes);
  const Image<std::uint16_t> values{says("rvl") ? decode_rvl(std::as_bytes(std::span{bytes}), name)
                                                : io::decode_u16(name, bytes)};
  if (!says("32FC1")) return depth_of_values(values, in_millimetres);
  return depth_of_values(values, [&](double value) { return value == 0 ? 0 : head.a / (value - head.b); });
}

Image<float> decode_disparities(messages::stereo_msgs::DisparityImage& message, const std::string& name) {
  const io::DisparityDepth depth{name, message.f, message.t, message.min_disparity, message.max_disparity};
  if (message.image.encoding != "32FC1") {
    throw InputError{
        name, fmt::format("the encoding \"{}\" of disparities is not read.", io::printable(message.image.encoding)),
        "A DisparityImage is 32FC1, in px."};
  }
  return depth_of<float>(pixels_of(message.image, CV_32FC1, name), depth);
}

}  // namespace

Image<float> decode_depth(std::span<const std::byte> cdr, const mcap::Topic& topic, const std::string& name) {
  if (topic.type == messages::stereo_msgs::DisparityImage::type_name) {
    messages::stereo_msgs::DisparityImage message;
    messages::decode(cdr, message);
    return decode_disparities(message, name);
  }
  if (topic.type == sensor_msgs::CompressedImage::type_name) {
    sensor_msgs::CompressedImage message;
    messages::decode(cdr, message);
    return decode_compressed_depth(message, name);
  }
  sensor_msgs::Image message;
  messages::decode(cdr, message);
  return depth_of_image(message, name);
}

double disparity_baseline_m(std::span<const std::byte> cdr) {
  messages::stereo_msgs::DisparityImage image;
  messages::decode(cdr, image);
  const double baseline_m{std::abs(double{image.t})};
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

Image<float> fit_depth(Image<float> depth_m, int width_px, int height_px, const std::string& name) {
  if (depth_m.width() == width_px && depth_m.height() == height_px) return depth_m;
  if (std::int64_t{depth_m.width()} * height_px != std::int64_t{depth_m.height()} * width_px) {
    throw InputError{
        name,
        fmt::format("depth has {}×{} px, but the images have {}×{}, which is no exact multiple or fraction.",
                    depth_m.width(), depth_m.height(), width_px, height_px),
        "Take depth that is aligned to the images."};
  }
  Image<float> fitted{width_px, height_px};
  for (int v{0}; v < height_px; ++v) {
    const float* const row{depth_m.row(static_cast<int>(std::int64_t{2 * v + 1} * depth_m.height() / (2 * height_px)))};
    for (int u{0}; u < width_px; ++u) {
      fitted(u, v) = row[std::int64_t{2 * u + 1} * depth_m.width() / (2 * width_px)];
    }
  }
  return fitted;
}

}  // namespace stereogrid::rosbag
