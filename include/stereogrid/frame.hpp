// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Position (m) and heading (rad, counter-clockwise, 0 along x) on the ground plane. `a_from_b` transforms points of
/// frame b to frame a.
struct Pose2 {
  double x_m{0};
  double y_m{0};
  double yaw_rad{0};

  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// a_from_b applied to a point given in b.
[[nodiscard]] inline Point2 operator*(const Pose2& a_from_b, Point2 in_b) {
  const double c{std::cos(a_from_b.yaw_rad)};
  const double s{std::sin(a_from_b.yaw_rad)};
  return {a_from_b.x_m + c * in_b.x - s * in_b.y, a_from_b.y_m + s * in_b.x + c * in_b.y};
}

/// a_from_c = a_from_b · b_from_c; the heading is kept in (−π, π].
[[nodiscard]] inline Pose2 operator*(const Pose2& a_from_b, const Pose2& b_from_c) {
  const Point2 origin{a_from_b * Point2{b_from_c.x_m, b_from_c.y_m}};
  return {origin.x, origin.y, std::remainder(a_from_b.yaw_rad + b_from_c.yaw_rad, 2 * 3.14159265358979323846)};
}

[[nodiscard]] inline Pose2 inverse(const Pose2& a_from_b) {
  const double c{std::cos(a_from_b.yaw_rad)};
  const double s{std::sin(a_from_b.yaw_rad)};
  return {-c * a_from_b.x_m - s * a_from_b.y_m, s * a_from_b.x_m - c * a_from_b.y_m, -a_from_b.yaw_rad};
}

/// Projection of a camera's pose onto the ground: x forward, y left, heading of the optical axis. `world_from_camera`:
/// 3 × 4 row-major, metres; camera axes x right, y down, z forward.
[[nodiscard]] inline Pose2 ground_pose(std::span<const double, 12> world_from_camera) {
  const auto& m{world_from_camera};
  return {m[11], -m[3], std::atan2(-m[2], m[10])};
}

/// Pose of the camera frame on the ground in the vehicle frame: origin below the left camera, x along its optical axis.
[[nodiscard]] inline Pose2 camera_place(const Rig& rig) {
  return {rig.camera_x_m, rig.camera_y_m, rig.camera_yaw_rad};
}

/// Bearings from a camera's optical axis, rad, counter-clockwise.
struct HorizontalView {
  double right_rad;
  double left_rad;
};

/// Field of view of a camera: bearings of the outer edges of its first and last columns.
[[nodiscard]] inline HorizontalView horizontal_view(const Rig& rig) {
  return {-std::atan((rig.width_px - 0.5 - rig.cx_px) / rig.focal_px), std::atan((rig.cx_px + 0.5) / rig.focal_px)};
}

/// Grid of another source at a frame's time: a lidar, a second stereo pair (`observed` of its own pipeline, moved into
/// this vehicle frame), a map.
struct ObservedGrid {
  GridGeometry geometry;      ///< in the vehicle frame of the frame; any size of cells
  Image<float> occupancy;     ///< P(occupied) in [0, 1]; 0.5 = unknown
  Image<float> confidence{};  ///< confidence of each cell, in [0, 1]; 0: unknown; empty: 1
};

/// Meaning of a pixel, by a semantic segmentation of the left image. `none`: no statement.
enum class PixelLabel : std::uint8_t { none, ignore, passable, obstacle, mover };
constexpr std::array<std::string_view, 5> names_of(PixelLabel) {
  return {"none", "ignore", "passable", "obstacle", "mover"};
}

/// Images of a frame in foreign memory, used without a copy: {.left = {pixels, width, height, pitch}, .right = …}. Rows
/// may not overlap; the pitch of images stored upside down is negative.
struct FrameImages {
  View<const std::uint8_t> left{};
  View<const std::uint8_t> right{};  ///< same size; empty: `disparity` is used
  View<const float> disparity{};     ///< px of the left image, 0 = none; empty if there is a right image
};

/// Rectified grey pair, or left image with its disparities, and its time and pose.
struct StereoFrame {
  std::string name;                         ///< name in the input; used for output files
  std::int64_t index{0};                    ///< index in the input, from 0
  std::int64_t stamp_ns{0};                 ///< time of exposure, ns since any fixed instant
  Image<std::uint8_t> left;                 ///< reference image, see assign(); empty: only `others` have images
  Image<std::uint8_t> right;                ///< same size; empty: `disparity` is used
  Image<float> disparity;                   ///< px of the left image, 0 = none; empty if there is a right image
  std::optional<Pose2> world_from_vehicle;  ///< none: unknown
  std::vector<ObservedGrid> other_grids{};  ///< grids of other sources; fused with the stereo pair's grid
  Image<std::uint8_t> labels{};             ///< PixelLabel of each pixel of `left`; pixels to ignore have no disparity
  int camera{0};                            ///< index into Pipeline::rigs()
  std::vector<StereoFrame> others{};        ///< frames of other cameras, about the same time, without others
  std::string fault{};                      ///< cameras whose images could not be read, for a warning; empty: none

  /// Its own images.
  // NOLINTNEXTLINE(google-explicit-constructor): a frame has such images
  operator FrameImages() const { return {left.view(), right.view(), disparity.view()}; }
};

/// The frame of a camera: `frame` or one of its others; nullptr: it has none.
[[nodiscard]] inline const StereoFrame* frame_of(const StereoFrame& frame, int camera) {
  if (frame.camera == camera) return &frame;
  for (const StereoFrame& other : frame.others) {
    if (other.camera == camera) return &other;
  }
  return nullptr;
}

/// A recorded, simulated or live sequence of frames.
class STEREOGRID_EXPORT FrameSource {
 public:
  FrameSource() = default;
  FrameSource(const FrameSource&) = delete;
  FrameSource& operator=(const FrameSource&) = delete;
  virtual ~FrameSource() = default;

  [[nodiscard]] virtual const Rig& rig() const = 0;
  /// Rigs of all cameras, by StereoFrame::camera; the first is rig().
  [[nodiscard]] virtual std::span<const Rig> rigs() const { return {&rig(), 1}; }
  /// Names of several cameras, by StereoFrame::camera (PipelineOptions::camera_names); empty: they have none.
  [[nodiscard]] virtual std::vector<std::string> camera_names() const { return {}; }
  [[nodiscard]] virtual std::size_t size() const = 0;
  [[nodiscard]] virtual std::string name(std::size_t index) const = 0;
  /// Loads one frame. Safe to call from several threads. Throws InputError for an unusable frame; others may be usable.
  /// Throws DeviceError if it cannot be read now; trying again may help.
  [[nodiscard]] virtual StereoFrame load(std::size_t index) const = 0;
};

}  // namespace stereogrid
