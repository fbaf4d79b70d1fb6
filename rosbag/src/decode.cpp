// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/rosbag/decode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "pixels.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/messages/cdr.hpp"
#include "stereogrid/messages/sensor_msgs.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::rosbag {
namespace {

namespace sensor_msgs = messages::sensor_msgs;

/// Ways from the pixels of a message to grey that are no conversion of OpenCV's.
constexpr int is_grey{-1};
constexpr int first_channel{-2};   // Y of Y U Y V
constexpr int second_channel{-3};  // Y of U Y V Y
constexpr int is_planar{-4};       // Y of all pixels, chrominance behind them
constexpr int is_float{-5};

/// Layout of the pixels in a message, and their way to grey: of the list above, or of cv::cvtColor.
struct Encoding {
  std::string_view name;
  int type;
  int to_grey;
};

// OpenCV names a Bayer pattern by the second row's second and third pixel, ROS by the first row's beginning.
constexpr std::array known_encodings{std::to_array<Encoding>({{"mono8", CV_8UC1, is_grey},
                                                              {"8UC1", CV_8UC1, is_grey},
                                                              {"mono16", CV_16UC1, is_grey},
                                                              {"16UC1", CV_16UC1, is_grey},
                                                              {"32FC1", CV_32FC1, is_float},
                                                              {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY},
                                                              {"8UC3", CV_8UC3, cv::COLOR_BGR2GRAY},
                                                              {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY},
                                                              {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY},
                                                              {"8UC4", CV_8UC4, cv::COLOR_BGRA2GRAY},
                                                              {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY},
                                                              {"bgr16", CV_16UC3, cv::COLOR_BGR2GRAY},
                                                              {"16UC3", CV_16UC3, cv::COLOR_BGR2GRAY},
                                                              {"rgb16", CV_16UC3, cv::COLOR_RGB2GRAY},
                                                              {"bgra16", CV_16UC4, cv::COLOR_BGRA2GRAY},
                                                              {"16UC4", CV_16UC4, cv::COLOR_BGRA2GRAY},
                                                              {"rgba16", CV_16UC4, cv::COLOR_RGBA2GRAY},
                                                              {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY},
                                                              {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY},
                                                              {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY},
                                                              {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY},
                                                              {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY},
                                                              {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY},
                                                              {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY},
                                                              {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY},
                                                              {"yuv422_yuy2", CV_8UC2, first_channel},
                                                              {"yuyv", CV_8UC2, first_channel},
                                                              {"yuyv422", CV_8UC2, first_channel},
                                                              {"yuy2", CV_8UC2, first_channel},
                                                              {"yuv422", CV_8UC2, second_channel},
                                                              {"uyvy", CV_8UC2, second_channel},
                                                              {"uyvy422", CV_8UC2, second_channel},
                                                              {"nv12", CV_8UC1, is_planar},
                                                              {"i420", CV_8UC1, is_planar},
                                                              {"yv12", CV_8UC1, is_planar},
                                                              {"yuv420", CV_8UC1, is_planar},
                                                              {"nv21", CV_8UC1, is_planar},
                                                              {"nv24", CV_8UC1, is_planar}})};

/// Case is ignored: drivers write YUYV, too.
bool is_same_word(std::string_view a, std::string_view b) {
  const auto lower = [](unsigned char letter) { return std::tolower(letter); };
  return std::ranges::equal(a, b, {}, lower, lower);
}

const Encoding& encoding_of(const sensor_msgs::Image& message, const std::string& name) {
  const auto is_it = [&](const Encoding& known) { return is_same_word(known.name, message.encoding); };
  const auto* const found{std::ranges::find_if(known_encodings, is_it)};
  if (found != known_encodings.end()) return *found;
  throw InputError{
      name, fmt::format("the encoding \"{}\" is not read.", io::printable(message.encoding)),
      "Read are mono8, mono16, bgr8, rgb8, bgra8, rgba8 and bayer_…8, the same with 16 bits, yuv422, uyvy, "
      "yuv422_yuy2, yuyv, nv12, nv21, nv24, yuv420, 8UC1, 8UC3, 8UC4, 16UC1, 16UC3, 16UC4, 32FC1."};
}

/// The height of some drivers counts the rows of the chrominance, too.
void leave_luminance(sensor_msgs::Image& message) {
  const bool is_half{!is_same_word(message.encoding, "nv24")};
  const std::uint64_t rows{is_half ? std::uint64_t{message.height} * 3 / 2 : std::uint64_t{message.height} * 3};
  if (message.data.size() >= rows * message.step || message.height % 3 != 0) return;
  message.height = is_half ? message.height / 3 * 2 : message.height / 3;
}

/// Floats up to 1, up to 255, or beyond, as 16 bits; 0 for NaN, infinity and negative values.
cv::Mat whole_numbers_of(const cv::Mat& floats) {
  cv::Mat known{floats.clone()};
  cv::patchNaNs(known, 0);
  known.setTo(0, known < 0);
  known.setTo(0, known > 65535);
  double brightest{0};
  cv::minMaxLoc(known, nullptr, &brightest);
  cv::Mat samples;
  known.convertTo(samples, CV_16U, brightest <= 1 ? 65535 : brightest <= 255 ? 257 : 1);
  return samples;
}

cv::Mat grey_of(const cv::Mat& pixels, int to_grey) {
  cv::Mat grey;
  if (to_grey == is_grey || to_grey == is_planar) return pixels;
  if (to_grey == is_float) return whole_numbers_of(pixels);
  if (to_grey == first_channel || to_grey == second_channel) {
    cv::extractChannel(pixels, grey, to_grey == first_channel ? 0 : 1);
  } else {
    cv::cvtColor(pixels, grey, to_grey);
  }
  return grey;
}

io::ScaledImage decode_plain(std::span<const std::byte> cdr, const std::string& name) {
  sensor_msgs::Image message;
  messages::decode(cdr, message);
  const Encoding& encoding{encoding_of(message, name)};
  if (encoding.to_grey == is_planar) leave_luminance(message);
  cv::Mat grey;
  try {
    grey = grey_of(pixels_of(message, encoding.type, name), encoding.to_grey);
  } catch (const cv::Exception&) {  // a Bayer pattern of one row
    throw InputError{name, "the image is too small for its encoding.", "Record it again."};
  }
  io::ScaledImage image{{}, io::sample_bits(view_of(grey))};
  assign(image.grey, view_of(grey, image.bits));
  return image;
}

io::ScaledImage decode_compressed(std::span<const std::byte> cdr, const std::string& name) {
  sensor_msgs::CompressedImage message;
  messages::decode(cdr, message);
  std::string format{message.format};
  std::ranges::transform(format, format.begin(), [](unsigned char letter) { return std::tolower(letter); });
  for (const std::string_view video : {"h264", "h.264", "h265", "h.265", "hevc", "av1"}) {
    if (format.find(video) == std::string::npos) continue;
    throw InputError{name, fmt::format("holds video ({}), which is not read (allowed: PNG, JPEG, TIFF).", video),
                     "Decode it into sensor_msgs/Image and record that."};
  }
  return io::decode_scaled(name, {message.data.begin(), message.data.end()});
}

}  // namespace

cv::Mat pixels_of(messages::sensor_msgs::Image& message, int type, const std::string& name) {
  if (message.step % CV_ELEM_SIZE1(type) != 0) {
    throw InputError{
        name,
        fmt::format("{} bytes a row hold no whole number of {} bit samples.", message.step, 8 * CV_ELEM_SIZE1(type)),
        "Its driver should write a step that is a multiple of the sample's size."};
  }
  const std::uint64_t row_bytes{std::uint64_t{message.width} * CV_ELEM_SIZE(type)};
  const bool fits{message.width > 0 && message.height > 0 &&
                  std::max(message.width, message.height) <= io::largest_side_px && message.step >= row_bytes &&
                  std::uint64_t{message.step} * (message.height - 1) + row_bytes <= message.data.size()};
  if (!fits) {
    throw InputError{name,
                     fmt::format("the image says {}×{} px, {} bytes a row, but has {} bytes.", message.width,
                                 message.height, message.step, message.data.size()),
                     "Record it again."};
  }
  const auto sample{static_cast<std::size_t>(CV_ELEM_SIZE1(type))};
  if (message.is_bigendian != 0 && sample > 1) {
    for (auto at{message.data.begin()}; message.data.end() - at >= static_cast<std::ptrdiff_t>(sample);) {
      std::reverse(at, at + static_cast<std::ptrdiff_t>(sample));
      at += static_cast<std::ptrdiff_t>(sample);
    }
  }
  return {static_cast<int>(message.height), static_cast<int>(message.width), type, message.data.data(), message.step};
}

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
