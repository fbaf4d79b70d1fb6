// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/decode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::rosbag {
namespace {

namespace sensor_msgs = messages::sensor_msgs;

/// How pixels lie in a message, and how they become grey; -1: they are.
struct Encoding {
  std::string_view name;
  int type;
  int to_grey;
};

// OpenCV names a Bayer pattern by the second row's second and third pixel, ROS by the first row's beginning.
constexpr std::array<Encoding, 14> encodings{{{"mono8", CV_8UC1, -1},
                                              {"8UC1", CV_8UC1, -1},
                                              {"mono16", CV_16UC1, -1},
                                              {"16UC1", CV_16UC1, -1},
                                              {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
                                              {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
                                              {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
                                              {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
                                              {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY},
                                              {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
                                              {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
                                              {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
                                              {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
                                              {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY}}};

const Encoding& encoding_of(const sensor_msgs::Image& message, const std::string& name) {
  const auto* const found{std::ranges::find(encodings, message.encoding, &Encoding::name)};
  if (found != encodings.end()) return *found;
  throw InputError{name, fmt::format("the encoding \"{}\" is not read.", io::printable(message.encoding)),
                   "Read are mono8, mono16, bgr8, rgb8, bgra8, rgba8, bayer_…8, 8UC1, 8UC3, 8UC4, 16UC1."};
}

/// The message's own memory; checked to be as large as it says.
cv::Mat pixels_of(sensor_msgs::Image& message, int type, const std::string& name) {
  constexpr std::uint32_t largest_side_px{32768};
  if (message.step % CV_ELEM_SIZE1(type) != 0) {
    throw InputError{name, fmt::format("{} bytes a row hold no whole number of 16 bit samples.", message.step),
                     "Its driver should write a step of twice the width, or more by an even number."};
  }
  const std::uint64_t row_bytes{std::uint64_t{message.width} * CV_ELEM_SIZE(type)};
  const bool fits{message.width > 0 && message.height > 0 && message.width <= largest_side_px &&
                  message.height <= largest_side_px && message.step >= row_bytes &&
                  std::uint64_t{message.step} * (message.height - 1) + row_bytes <= message.data.size()};
  if (!fits) {
    throw InputError{name,
                     fmt::format("the image says {}×{} px, {} bytes a row, but has {} bytes.", message.width,
                                 message.height, message.step, message.data.size()),
                     "Record it again."};
  }
  if (message.is_bigendian != 0 && CV_MAT_DEPTH(type) == CV_16U) {
    for (std::size_t i{0}; i + 1 < message.data.size(); i += 2) std::swap(message.data[i], message.data[i + 1]);
  }
  return {static_cast<int>(message.height), static_cast<int>(message.width), type, message.data.data(), message.step};
}

io::ScaledImage decode_plain(std::span<const std::byte> cdr, const std::string& name) {
  sensor_msgs::Image message;
  messages::decode(cdr, message);
  const Encoding& encoding{encoding_of(message, name)};
  cv::Mat grey{pixels_of(message, encoding.type, name)};
  if (encoding.to_grey >= 0) {
    try {
      cv::Mat converted;
      cv::cvtColor(grey, converted, encoding.to_grey);
      grey = converted;
    } catch (const cv::Exception&) {  // a Bayer pattern of one row
      throw InputError{name, "the image is too small for its encoding.", "Record it again."};
    }
  }
  io::ScaledImage image{{}, io::sample_bits(view_of(grey))};
  assign(image.grey, view_of(grey, image.bits));
  return image;
}

io::ScaledImage decode_compressed(std::span<const std::byte> cdr, const std::string& name) {
  sensor_msgs::CompressedImage message;
  messages::decode(cdr, message);
  return io::decode_scaled(name, {message.data.begin(), message.data.end()});
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
  return is_compressed ? decode_compressed(cdr, name) : decode_plain(cdr, name);
}

}  // namespace stereogrid::rosbag
