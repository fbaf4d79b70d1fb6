// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/ros_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/opencv.hpp"

namespace stereogrid::io {
namespace {

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

const Encoding& encoding_of(const RosImage& image, const std::string& name) {
  const auto is_it = [&](const Encoding& known) { return is_same_word(known.name, image.encoding); };
  const auto* const found{std::ranges::find_if(known_encodings, is_it)};
  if (found != known_encodings.end()) return *found;
  throw InputError{
      name, fmt::format("the encoding \"{}\" is not read.", image.encoding),
      "Read are mono8, mono16, bgr8, rgb8, bgra8, rgba8 and bayer_…8, the same with 16 bits, yuv422, uyvy, "
      "yuv422_yuy2, yuyv, nv12, nv21, nv24, yuv420, 8UC1, 8UC3, 8UC4, 16UC1, 16UC3, 16UC4, 32FC1."};
}

/// The height of some drivers counts the rows of the chrominance, too.
std::uint32_t luminance_rows(const RosImage& image) {
  const bool is_half{!is_same_word(image.encoding, "nv24")};
  const std::uint64_t rows{is_half ? std::uint64_t{image.height_px} * 3 / 2 : std::uint64_t{image.height_px} * 3};
  if (image.data.size() >= rows * image.step_bytes || image.height_px % 3 != 0) return image.height_px;
  return is_half ? image.height_px / 3 * 2 : image.height_px / 3;
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

ScaledImage decode_plain(RosImage image, const std::string& name) {
  const Encoding& encoding{encoding_of(image, name)};
  if (encoding.to_grey == is_planar) image.height_px = luminance_rows(image);
  const bool is_flagged{image.is_bigendian};
  cv::Mat grey;
  try {
    grey = grey_of(ros_pixels(image, encoding.type, name), encoding.to_grey);
  } catch (const cv::Exception&) {  // a Bayer pattern of one row
    throw InputError{name, "the image is too small for its encoding.", "Record it again."};
  }
  ScaledImage scaled{{}, sample_bits(view_of(grey)), image.is_bigendian != is_flagged};
  assign(scaled.grey, view_of(grey, scaled.bits));
  return scaled;
}

ScaledImage decode_compressed(const RosImage& image, const std::string& name) {
  std::string format{image.encoding};
  std::ranges::transform(format, format.begin(), [](unsigned char letter) { return std::tolower(letter); });
  for (const std::string_view video : {"h264", "h.264", "h265", "h.265", "hevc", "av1"}) {
    if (format.find(video) == std::string::npos) continue;
    throw InputError{name, fmt::format("holds video ({}), which is not read (allowed: PNG, JPEG, TIFF).", video),
                     "Decode it into sensor_msgs/Image and record that."};
  }
  return decode_scaled(name, {image.data.begin(), image.data.end()});
}

}  // namespace

namespace {

/// Mean difference of samples two pixels apart (of one colour in a Bayer pattern) over the mean deviation of all, of
/// some rows of 16-bit samples.
double roughness(const cv::Mat& samples, bool swaps) {
  constexpr int rows_apart{8};
  const int apart{2 * samples.channels()};
  std::vector<int> values;
  double steps{0};
  double sum{0};
  for (int v{0}; v < samples.rows; v += rows_apart) {
    const auto* const row{samples.ptr<std::uint16_t>(v)};
    for (int i{0}; i < samples.cols * samples.channels(); ++i) {
      const int value{swaps ? (row[i] & 0xff) << 8 | row[i] >> 8 : row[i]};
      values.push_back(value);
      if (i >= apart) steps += std::abs(value - values[values.size() - 1 - static_cast<std::size_t>(apart)]);
      sum += value;
    }
  }
  const double mean{sum / static_cast<double>(values.size())};
  double spread{0};
  for (const int value : values) spread += std::abs(value - mean);
  return spread > 0 ? steps / spread : 0;
}

}  // namespace

cv::Mat ros_pixels(RosImage& image, int type, const std::string& name) {
  const auto sample{static_cast<std::size_t>(CV_ELEM_SIZE1(type))};
  if (image.step_bytes % sample != 0) {
    throw InputError{
        name, fmt::format("{} bytes a row hold no whole number of {} bit samples.", image.step_bytes, 8 * sample),
        "Its driver should write a step that is a multiple of the sample's size."};
  }
  const std::uint64_t row_bytes{std::uint64_t{image.width_px} * CV_ELEM_SIZE(type)};
  const bool fits{image.width_px > 0 && image.height_px > 0 &&
                  std::max(image.width_px, image.height_px) <= largest_side_px && image.step_bytes >= row_bytes &&
                  std::uint64_t{image.step_bytes} * (image.height_px - 1) + row_bytes <= image.data.size()};
  if (!fits) {
    throw InputError{name,
                     fmt::format("the image says {}×{} px, {} bytes a row, but has {} bytes.", image.width_px,
                                 image.height_px, image.step_bytes, image.data.size()),
                     "Record it again."};
  }
  const cv::Mat pixels{static_cast<int>(image.height_px), static_cast<int>(image.width_px), type,
                       const_cast<std::uint8_t*>(image.data.data()), image.step_bytes};
  if (CV_MAT_DEPTH(type) == CV_16U) {
    constexpr double clearly{0.4};  // images reach 0.3 of the wrong order; noise is as rough in both
    if (roughness(pixels, !image.is_bigendian) < clearly * roughness(pixels, image.is_bigendian)) {
      image.is_bigendian = !image.is_bigendian;
    }
  }
  if (!image.is_bigendian || sample == 1) return pixels;
  cv::Mat swapped{pixels.clone()};
  for (std::uint8_t* at{swapped.data}; at != swapped.dataend; at += sample) std::reverse(at, at + sample);
  return swapped;
}

ScaledImage decode_ros_image(const RosImage& image, const std::string& name) {
  return image.is_compressed ? decode_compressed(image, name) : decode_plain(image, name);
}

}  // namespace stereogrid::io
