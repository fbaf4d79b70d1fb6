// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid {

/// What the odometry says of one frame.
struct OdometryStep {
  /// before_from_now, 3 × 4 row-major, of the camera (x right, y down, z forward), metres: takes points of this frame's
  /// camera to that of the frame before. The identity at the first frame.
  std::array<double, 12> camera_motion{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Pose2 world_from_vehicle;  ///< world: the vehicle frame of the first frame
  bool measured{false};      ///< false: the first frame, or the last motion carried on
  bool standing{false};      ///< nothing in the picture moves: the motion is exactly none
  int tracked{0};            ///< points followed from the reference frame to this one, with depth
  int inliers{0};            ///< of these, points that agree on the motion
  double spread{0};          ///< share of the parts of the picture (6 × 3) that have inliers
  std::string warning;       ///< empty: none
};

/// What the odometry remembers between two frames.
struct OdometryState {
  struct Landmark {
    std::array<float, 2> in_reference_px;
    std::array<float, 3> in_camera_m;
    std::array<float, 2> last_seen_px;
  };
  Image<std::uint8_t> reference;  ///< left image of the frame that the landmarks are of; empty: no frame yet
  std::vector<Landmark> landmarks;
  Pose2 world_from_reference;
  Pose2 world_from_last;
  std::array<double, 12> reference_from_last{};  ///< 3 × 4 row-major
  std::optional<std::array<double, 6>> speed;    ///< rotation vector, rad/s, and translation, m/s
  double unmeasured_s{0};
  std::optional<std::int64_t> last_stamp_ns;
};

/// Visual odometry from a rectified stereo pair: corners spread over the picture (Shi and Tomasi), followed from frame
/// to frame and from left to right by pyramidal Lucas-Kanade, motion from 3D to 2D by RANSAC and least squares
/// (OpenCV).
///
/// The reference stays the same frame until the camera has moved on, so a standing camera does not drift. What would
/// need an implausible acceleration (something large moves through the picture) is taken for another's motion; then the
/// points that agree with a constant motion decide, and where they are too few the last motion is carried on, with a
/// warning. Steps are put together on the ground, seen with the rig's pitch and roll. The same result for any number of
/// threads.
class STEREOGRID_EXPORT VisualOdometry {
 public:
  /// `mask`: as PipelineOptions::mask; where the vehicle itself is seen no corners are taken. Throws InputError where
  /// it is neither empty nor of the rig's size.
  explicit VisualOdometry(const Rig& rig, Image<std::uint8_t> mask = {});
  VisualOdometry(VisualOdometry&&) noexcept;
  VisualOdometry& operator=(VisualOdometry&&) noexcept;
  ~VisualOdometry();

  /// Takes the next frame, with a right image or with disparities; stamps must grow, frames may be missing. Throws
  /// InputError where the frame does not fit the rig; the state is then unchanged.
  OdometryStep update(const StereoFrame& frame);

  /// An odometry of the same rig that is given the state goes on exactly as this one would. Throws InputError where the
  /// reference image does not fit the rig; nothing has changed then.
  [[nodiscard]] OdometryState save_state() const;
  void load_state(const OdometryState& state);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid
