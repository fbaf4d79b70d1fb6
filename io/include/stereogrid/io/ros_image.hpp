// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"
#include "stereogrid/io/image_file.hpp"

namespace stereogrid::io {

/// View of a sensor_msgs/Image or CompressedImage.
struct RosImage {
  std::string_view encoding;  ///< format of a CompressedImage
  std::span<const std::uint8_t> data;
  bool is_compressed{true};  ///< the remaining fields are 0
  std::uint32_t width_px{0};
  std::uint32_t height_px{0};
  std::uint32_t step_bytes{0};
  bool is_bigendian{false};
};

/// `message`: with the fields of either type. The view refers to it.
template <class Message>
[[nodiscard]] RosImage ros_image_of(const Message& message) {
  if constexpr (requires { message.format; }) {
    return {message.format, message.data};
  } else {
    return {message.encoding,         message.data, false, message.width, message.height, message.step,
            message.is_bigendian != 0};
  }
}

/// Grey values at their own scale. `name`: for error messages. Throws InputError: damaged, or an unsupported encoding.
[[nodiscard]] STEREOGRID_EXPORT ScaledImage decode_ros_image(const RosImage& image, const std::string& name);

/// Depth along the camera's axis, m; 0 = none. Image: 16UC1 in mm, 32FC1 in m (REP 118). CompressedImage: PNG of 16
/// bits in mm, or the output of compressed_depth_image_transport (PNG or RVL of 16UC1 and 32FC1). NaN, infinity and
/// negative values are none. Throws InputError: damaged, or an unsupported encoding.
[[nodiscard]] STEREOGRID_EXPORT Image<float> decode_ros_depth(const RosImage& image, const std::string& name);

/// View of a stereo_msgs/DisparityImage.
struct RosDisparities {
  RosImage image;
  float focal_px{0};    ///< f
  float baseline_m{0};  ///< T
  float min_px{0};      ///< no limits unless min_px < max_px
  float max_px{0};
};

template <class Message>
[[nodiscard]] RosDisparities ros_disparities_of(const Message& message) {
  return {ros_image_of(message.image), message.f, message.t, message.min_disparity, message.max_disparity};
}

/// Depth along the camera's axis f·T/d, m; 0 = none, or outside the limits. Some publishers send u_right − u_left:
/// where the limits are not above 0, the sign of d, f and T does not count. Throws InputError: damaged, an unsupported
/// encoding, or f·T is 0 or not finite.
[[nodiscard]] STEREOGRID_EXPORT Image<float> decode_ros_disparities(const RosDisparities& disparities,
                                                                    const std::string& name);

/// Repeats or leaves out pixels to the size of the image. Throws InputError where the ratios of both sides differ.
[[nodiscard]] STEREOGRID_EXPORT Image<float> fit_depth(Image<float> depth_m, int width_px, int height_px,
                                                       const std::string& name);

}  // namespace stereogrid::io
