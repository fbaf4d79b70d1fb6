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
#include "stereogrid/pose_covariances.hpp"

namespace stereogrid {

/// Result of the odometry for one frame.
struct OdometryStep {
  /// before_from_now, 3 × 4 row-major, of the camera (x right, y down, z forward), metres: takes points of this frame's
  /// camera to that of the frame before. The identity at the first frame.
  std::array<double, 12> camera_motion{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Pose2 world_from_vehicle;  ///< world frame: the vehicle frame of the first frame
  /// From the residuals of the tracked points; without a measured motion, from the largest acceleration.
  PoseCovariances covariances;
  bool measured{false};  ///< false: the first frame, or continuation of the last motion
  bool standing{false};  ///< no motion in the image: the motion is exactly zero
  int tracked{0};        ///< points tracked from the reference frame to this one, with depth
  int inliers{0};        ///< points among them that agree on the motion
  double spread{0};      ///< share of the parts of the image (6 × 3) that have inliers
  std::optional<std::string> warning;
};

/// State of the odometry between two frames.
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
  std::array<double, 9> covariance_at_reference{};  ///< as PoseCovariances::pose, of world_from_reference
  std::array<double, 9>
      covariance_since_reference{};  ///< covariance of the motion from the reference frame, vehicle axes
  std::optional<std::int64_t> last_stamp_ns;
};

/// Visual odometry from a rectified stereo pair: corners spread over the image (Shi and Tomasi), tracked from frame to
/// frame and from left to right by pyramidal Lucas-Kanade, motion from 3D to 2D by RANSAC and least squares (OpenCV).
///
/// The reference frame changes only after the camera has moved, so a static camera does not drift. Motion with an
/// implausible acceleration (something large moves through the image) is rejected. Then the points that agree with
/// constant motion decide; if they are too few, the last motion continues, with a warning. Steps are accumulated on the
/// ground, with the rig's pitch and roll. The result does not depend on the number of threads.
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

  /// An odometry of the same rig with this state continues with the same results. Throws InputError where the reference
  /// image does not fit the rig; nothing has changed then.
  [[nodiscard]] OdometryState save_state() const;
  void load_state(const OdometryState& state);

 private:
  struct STEREOGRID_HIDDEN Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stereogrid
