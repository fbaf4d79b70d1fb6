// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/core/affine.hpp>
#include <optional>
#include <vector>

#include "stereogrid/frame.hpp"

namespace stereogrid {

/// Image pyramid of optical flow, level 0 first, as OpenCV builds it.
using Pyramid = std::vector<cv::Mat>;

[[nodiscard]] Pyramid pyramid_of(const Image<std::uint8_t>& image);

/// Points of the reference frame that have depth.
struct Landmarks {
  std::vector<cv::Point2f> at_px;      ///< in the left image
  std::vector<cv::Point3f> in_camera;  ///< m, x right, y down, z forward
};

/// Positions of landmarks in a later left image.
struct Tracks {
  std::vector<int> landmark;  ///< which of them
  std::vector<cv::Point2f> at_px;
};

/// Corners spread over the left image, with a disparity. It is matched in the right image with subpixel accuracy, in
/// rows as well, since rows of real pairs may differ; or read from external disparities. No corners where `mask` is 0;
/// it may be empty.
[[nodiscard]] Landmarks find_landmarks(const StereoFrame& frame, const Pyramid& left, const Rig& rig,
                                       const Image<std::uint8_t>& mask);

/// Follows landmarks forth and back again; those that do not come home are left out. `now_from_reference`: where the
/// camera is expected.
[[nodiscard]] Tracks follow(const Landmarks& landmarks, const Pyramid& reference, const Pyramid& now,
                            const cv::Affine3d& now_from_reference, const Rig& rig);

/// Projection of a point in front of the camera.
[[nodiscard]] inline cv::Point2d project(const cv::Affine3d& camera_from_points, const cv::Point3f& point,
                                         const Rig& rig) {
  const cv::Vec3d p{camera_from_points * cv::Vec3d{point.x, point.y, point.z}};
  return {rig.cx_px + rig.focal_px * p[0] / p[2], rig.cy_px + rig.focal_px * p[1] / p[2]};
}

/// A motion that enough landmarks agree on.
struct MotionFit {
  cv::Affine3d now_from_reference;
  std::vector<int> inliers;  ///< places in the tracks
};

/// Motion of the camera. `expected`: by constant motion; none: unknown. If the majority's motion is not `plausible`,
/// the points near the expected motion decide. None: too few agree.
[[nodiscard]] std::optional<MotionFit> fit_motion(const Landmarks& landmarks, const Tracks& tracks,
                                                  const std::optional<cv::Affine3d>& expected, const Rig& rig,
                                                  const std::function<bool(const cv::Affine3d&)>& plausible);

/// Covariance of a fitted motion over rotation (rad) and translation (m), axes of the camera now: the inverse normal
/// matrix of the `inliers`' reprojection, times the variance of their residuals.
[[nodiscard]] cv::Matx66d covariance_of(const cv::Affine3d& now_from_reference, const std::vector<int>& inliers,
                                        const Landmarks& landmarks, const Tracks& tracks, const Rig& rig);

}  // namespace stereogrid
