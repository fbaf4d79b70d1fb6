// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <opencv2/core.hpp>
#include <span>
#include <string>
#include <string_view>

#include "files/formats.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/image_file.hpp"
#include "stereogrid/io/ros_image.hpp"

namespace stereogrid::io {
namespace {

class Nibbles {
 public:
  Nibbles(std::span<const std::byte> bytes, const std::string& name) : bytes_{bytes}, name_{name} {}

  [[noreturn]] void fail() const { throw InputError{name_, "the RVL depth is damaged.", "Record it again."}; }

  /// Three bits per nibble, the lowest first; the fourth says that more follow.
  std::uint32_t number() {
    std::uint32_t value{0};
    for (int shift{0}; shift < 32; shift += 3) {
      const std::uint32_t nibble{next()};
      value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0) return value;
    }
    fail();
  }

  std::uint32_t word() {
    std::uint32_t value{0};
    if (bytes_.size() < sizeof value) fail();
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }

 private:
  std::uint32_t next() {
    if (left_ == 0) {
      word_ = word();
      left_ = 8;
    }
    --left_;
    return (word_ >> (4 * left_)) & 15U;
  }

  std::span<const std::byte> bytes_;
  const std::string& name_;
  std::uint32_t word_{0};
  unsigned left_{0};
};

/// Decodes RVL (Wilson, ISS 2017) as compressed_depth_image_transport writes it: width and height, 32 bits each, then
/// runs of zeros and of differences in words of eight nibbles. Throws InputError: damaged.
Image<std::uint16_t> decode_rvl(std::span<const std::byte> bytes, const std::string& name) {
  Nibbles code{bytes, name};
  const std::uint32_t width{code.word()};
  const std::uint32_t height{code.word()};
  if (width == 0 || height == 0 || std::max(width, height) > io::largest_side_px ||
      std::uint64_t{width} * height > io::most_pixels) {
    code.fail();
  }
  Image<std::uint16_t> image{static_cast<int>(width), static_cast<int>(height)};
  std::uint16_t value{0};
  for (auto at{image.begin()}; at != image.end();) {
    const auto run = [&] {
      const std::uint32_t count{code.number()};
      if (count > static_cast<std::uint64_t>(image.end() - at)) code.fail();
      return static_cast<std::ptrdiff_t>(count);
    };
    at = std::fill_n(at, run(), std::uint16_t{0});
    if (at == image.end()) break;
    at = std::generate_n(at, run(), [&] {
      const std::uint32_t difference{code.number()};
      value = static_cast<std::uint16_t>(value + ((difference >> 1U) ^ (0U - (difference & 1U))));
      return value;
    });
  }
  return image;
}

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

Image<float> decode_ros_depth(const RosImage& message, const std::string& name) {
  RosImage image{message};
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
  auto [image, focal_px, baseline_m, min_px, max_px]{disparities};
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
        fmt::format("depth has {}×{} px, but the images have {}×{}, which is not an exact multiple or fraction.",
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
