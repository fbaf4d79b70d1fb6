// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "translate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <string_view>

#include "stereogrid/error.hpp"
#include "stereogrid/io/disparity_depth.hpp"
#include "stereogrid/io/poses.hpp"

namespace stereogrid_ros {
namespace {

using stereogrid::InputError;
using stereogrid::PixelFormat;

constexpr int no_bayer{-1};

struct Encoding {
  std::string_view name;
  PixelFormat format;
  int bayer{no_bayer};  ///< OpenCV's conversion to grey, named after the second row's second and third pixel
};

constexpr std::array<Encoding, 12> encodings{{{"mono8", PixelFormat::grey8},
                                              {"8UC1", PixelFormat::grey8},
                                              {"mono16", PixelFormat::grey16},
                                              {"16UC1", PixelFormat::grey16},
                                              {"bgr8", PixelFormat::bgr8},
                                              {"rgb8", PixelFormat::rgb8},
                                              {"bgra8", PixelFormat::bgra8},
                                              {"rgba8", PixelFormat::rgba8},
                                              {"bayer_rggb8", PixelFormat::grey8, cv::COLOR_BayerBG2GRAY},
                                              {"bayer_bggr8", PixelFormat::grey8, cv::COLOR_BayerRG2GRAY},
                                              {"bayer_gbrg8", PixelFormat::grey8, cv::COLOR_BayerGR2GRAY},
                                              {"bayer_grbg8", PixelFormat::grey8, cv::COLOR_BayerGB2GRAY}}};

/// 3 × 4, row-major. Throws InputError: the rotation is not of length 1.
std::array<double, 12> matrix_of(const geometry_msgs::msg::Transform& transform) {
  const auto& q{transform.rotation};
  const auto unit{stereogrid::io::unit_quaternion({q.x, q.y, q.z, q.w})};
  if (!unit) {
    throw InputError{"TF",
                     "a rotation is a quaternion of length " +
                         std::to_string(std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w)) +
                         " (allowed 0.99 to 1.01).",
                     "Correct what publishes the transforms."};
  }
  const auto& [x, y, z, w]{*unit};
  const auto& t{transform.translation};
  return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),     t.x,
          2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),     t.y,
          2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y), t.z};
}

void check_bytes(const sensor_msgs::msg::Image& image, std::uint64_t pixel_bytes, const std::string& name,
                 bool has_endianness) {
  const std::uint64_t row_bytes{image.width * pixel_bytes};
  if (image.height == 0 || image.width == 0 || image.height > 32768 || image.width > 32768 || image.step < row_bytes ||
      std::uint64_t{image.step} * (image.height - 1) + row_bytes > image.data.size()) {
    throw InputError{name, "the image has fewer bytes than its size requires.", "Check its publisher."};
  }
  if (image.is_bigendian != 0 && has_endianness) {
    throw InputError{name, "big-endian pixels are unsupported.", "Publish little-endian ones, or mono8."};
  }
}

/// Depth of values of type T; a depth that is not finite and above 0 is none.
template <class T, class Metres>
stereogrid::Image<float> depth_of_values(const sensor_msgs::msg::Image& image, const char* name, Metres metres) {
  check_bytes(image, sizeof(T), name, true);
  stereogrid::Image<float> depth_m{static_cast<int>(image.width), static_cast<int>(image.height)};
  for (std::size_t v{0}; v < image.height; ++v) {
    for (std::size_t u{0}; u < image.width; ++u) {
      T value{};
      std::memcpy(&value, image.data.data() + v * image.step + u * sizeof(T), sizeof(T));
      const float depth{static_cast<float>(metres(value))};
      depth_m.row(static_cast<int>(v))[u] = depth > 0 && std::isfinite(depth) ? depth : 0;
    }
  }
  return depth_m;
}

}  // namespace

stereogrid::Image<float> depth_of(const sensor_msgs::msg::Image& image) {
  constexpr const char* name{"depth image"};
  if (image.encoding == "16UC1" || image.encoding == "mono16") {
    return depth_of_values<std::uint16_t>(image, name, [](double millimetres) { return millimetres * 0.001; });
  }
  if (image.encoding == "32FC1") return depth_of_values<float>(image, name, [](double metres) { return metres; });
  throw InputError{name, "unsupported encoding: " + image.encoding + ".", "Publish 16UC1 (mm) or 32FC1 (m)."};
}

stereogrid::Image<float> depth_of(const stereo_msgs::msg::DisparityImage& disparity) {
  constexpr const char* name{"disparity image"};
  if (disparity.image.encoding != "32FC1") {
    throw InputError{name, "unsupported encoding: " + disparity.image.encoding + ".", "Publish 32FC1 (px)."};
  }
  return depth_of_values<float>(
      disparity.image, name,
      stereogrid::io::DisparityDepth{name, disparity.f, disparity.t, disparity.min_disparity, disparity.max_disparity});
}

stereogrid::PixelView pixels_of(const sensor_msgs::msg::Image& image, const std::string& name, cv::Mat& grey) {
  const auto* const encoding{std::ranges::find(encodings, image.encoding, &Encoding::name)};
  if (encoding == encodings.end()) {
    throw InputError{name, "unsupported encoding: " + image.encoding + ".",
                     "Convert the images to mono8 or bgr8 (image_proc)."};
  }
  check_bytes(image, static_cast<std::uint64_t>(bytes_per_pixel(encoding->format)), name,
              encoding->format == PixelFormat::grey16);
  const int width{static_cast<int>(image.width)};
  const int height{static_cast<int>(image.height)};
  if (encoding->bayer == no_bayer) {
    return {image.data.data(), width, height, static_cast<std::ptrdiff_t>(image.step), encoding->format, 0};
  }
  if (width < 3 || height < 3) throw InputError{name, "a Bayer image is smaller than 3×3 px.", "Publish mono8."};
  // not written to
  const cv::Mat pattern{height, width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data()), image.step};
  cv::cvtColor(pattern, grey, encoding->bayer);
  return {grey.data, width, height, static_cast<std::ptrdiff_t>(grey.step[0]), PixelFormat::grey8, 0};
}

stereogrid::io::RosCamera camera_of(const sensor_msgs::msg::CameraInfo& info, const std::string& name) {
  if (info.binning_x > 1 || info.binning_y > 1 || info.roi.x_offset != 0 || info.roi.y_offset != 0) {
    throw InputError{name, "images with binning or a roi are unsupported.", "Publish whole images."};
  }
  stereogrid::io::RosCamera camera{
      name,  static_cast<int>(info.width), static_cast<int>(info.height), info.distortion_model, info.d, info.k, info.r,
      info.p};
  if (camera.d.empty() && camera.distortion_model != "equidistant") {  // simulators
    camera.distortion_model = "plumb_bob";
    camera.d.resize(5);
  }
  return camera;
}

stereogrid::Pose2 pose_of(const geometry_msgs::msg::Transform& world_from_camera) {
  const std::array<double, 12> m{matrix_of(world_from_camera)};
  return {m[3], m[7], std::atan2(m[6], m[2])};
}

void set_extrinsics(stereogrid::Rig& rig, const geometry_msgs::msg::Transform& base_from_camera) {
  const std::array<double, 12> m{matrix_of(base_from_camera)};
  const double right_z{m[8]};
  const double down_z{m[9]};
  const double forward_z{m[10]};
  rig.camera_height_m = m[11];
  rig.camera_pitch_rad = std::asin(std::clamp(-forward_z, -1.0, 1.0));
  rig.camera_roll_rad = std::atan2(-right_z, -down_z);
  if (rig.camera_height_m > 0 && std::abs(forward_z) < 0.99) return;
  throw InputError{"TF", "the left camera is not above z = 0 of the base frame, or points straight up or down.",
                   "Set robot_base_frame to a frame on the road (base_footprint), or to \"\"."};
}

}  // namespace stereogrid_ros
