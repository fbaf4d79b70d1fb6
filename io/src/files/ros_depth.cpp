// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <opencv2/core.hpp>
#include <string_view>

#include "files/ros_pixels.hpp"
#include "files/rvl.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/ros_image.hpp"

namespace stereogrid::io {
namespace {

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

Image<float> decode_compressed_depth(const RosImage& image, const std::string& name) {
  std::string bytes{image.data.begin(), image.data.end()};
  const auto in_millimetres = [](double z) { return z * millimetre_m; };
  if (bytes.starts_with("\x89PNG")) return depth_of_values(decode_u16(name, bytes), in_millimetres);
  const auto says = [&](std::string_view word) { return image.encoding.find(word) != std::string_view::npos; };
  if (says("jpeg") || bytes.size() < CompressedDepth::head_bytes) {
    throw InputError{name, fmt::format("depth as \"{}\" is not read.", image.encoding),
                     std::string{depth_kinds} + " Set the publisher's compressedDepth format to png or rvl."};
  }
  CompressedDepth head;
  std::memcpy(&head.a, bytes.data() + 4, sizeof head.a);
  std::memcpy(&head.b, bytes.data() + 8, sizeof head.b);
  bytes.erase(0, CompressedDepth::head_bytes);
  const Image<std::uint16_t> values{says("rvl") ? decode_rvl(std::as_bytes(std::span{bytes}), name)
                                                : decode_u16(name, bytes)};
  if (!says("32FC1")) return depth_of_values(values, in_millimetres);
  return depth_of_values(values, [&](double value) { return value == 0 ? 0 : head.a / (value - head.b); });
}

}  // namespace

Image<float> decode_ros_depth(const RosImage& image, const std::string& name) {
  if (image.is_compressed) return decode_compressed_depth(image, name);
  if (image.encoding == "16UC1" || image.encoding == "mono16") {
    return depth_of<std::uint16_t>(ros_pixels(image, CV_16UC1, name), [](double z) { return z * millimetre_m; });
  }
  if (image.encoding == "32FC1") {
    return depth_of<float>(ros_pixels(image, CV_32FC1, name), [](double z) { return z; });
  }
  throw InputError{name, fmt::format("the encoding \"{}\" of depth is not read.", image.encoding), depth_kinds};
}

Image<float> decode_ros_disparities(const RosDisparities& disparities, const std::string& name) {
  const auto& [image, focal_px, baseline_m, min_px, max_px]{disparities};
  const double focal_baseline_pxm{std::abs(double{focal_px} * baseline_m)};
  if (!(focal_baseline_pxm > 0) || !std::isfinite(focal_baseline_pxm)) {
    throw InputError{name, fmt::format("the DisparityImage has f {:g} px and T {:g} m.", focal_px, baseline_m),
                     "Both are above 0: correct what publishes it, or record depth."};
  }
  if (image.encoding != "32FC1") {
    throw InputError{name, fmt::format("the encoding \"{}\" of disparities is not read.", image.encoding),
                     "A DisparityImage is 32FC1, in px."};
  }
  const bool has_limits{max_px > min_px};
  const bool is_negative{min_px < 0 && max_px <= 0};
  return depth_of<float>(ros_pixels(image, CV_32FC1, name), [=, min = min_px, max = max_px](float disparity_px) {
    const float d{is_negative ? -disparity_px : disparity_px};
    const bool is_outside{has_limits && (disparity_px < min || disparity_px > max)};
    return is_outside || !(d > 0) ? 0 : focal_baseline_pxm / d;
  });
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

}  // namespace stereogrid::io
