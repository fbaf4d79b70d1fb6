// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/yaml_group.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Throws InputError where no camera is like that.
void check_camera(const CameraModel& camera, const Origin& origin);

/// The camera of a 3 × 3 matrix K, row-major, without distortion.
[[nodiscard]] CameraModel camera_of(const std::vector<double>& matrix, const Origin& origin, const char* key);

/// From a 3 × 3 matrix, row-major, or a Rodrigues vector.
[[nodiscard]] cv::Matx33d rotation_of(const std::vector<double>& numbers, const Origin& origin, const char* key);

void set_transform(RawPair& raw, const cv::Matx33d& rotation, const cv::Vec3d& translation_m);

/// A pair with the optics of a rectified one, but another cx of the right camera: `raw` where it differs.
void take_row_aligned(Calibration& calibration, const Rig& optics, double right_cx_px);

/// Sets the baseline of another tool's file to the measured one, if given; else throws InputError if the file has
/// another unit than metres.
void take_unit(Calibration& calibration, const Origin& origin, const CalibrationRequest& request);

/// Finds the rig of a raw pair, and drops `raw` where the pair is rectified as it is. Width and height of the rig may
/// be 0.
void take_rig_of_raw(Calibration& calibration, const Origin& origin, const CalibrationRequest& request);

/// One camera as both, with a virtual baseline unless one is requested.
void take_single(Calibration& calibration, const CameraModel& camera, const Origin& origin,
                 const CalibrationRequest& request);

/// Rig and unit of a pair whose extrinsics are a rigid transform of points of the left camera into the right one.
void take_pair(Calibration& calibration, const CameraModel& left, const CameraModel& right,
               const cv::Matx44d& right_from_left, const Origin& origin, const CalibrationRequest& request);

/// Adapts the cameras of `raw`, or else the rig, to the images' size; no effect where that is unknown. Scales a
/// calibration of another size where the ratio is exact, and notes it. Warns of a principal point that is probably that
/// of other images. Throws InputError: no exact ratio; in a calibration without a size, a principal point far from the
/// middle. The caller rectifies a raw pair again.
void fit_size(Calibration& calibration, const Origin& origin, const CalibrationRequest& request);

/// A rigid transform of 12 or 16 numbers, row-major. Throws InputError: no rotation, transposed.
[[nodiscard]] cv::Matx44d rigid_of(const std::vector<double>& numbers, const Origin& origin, const char* key);

/// From a quaternion x y z w of length 1 (to 1 %). Throws InputError.
[[nodiscard]] cv::Matx44d rigid_of(const std::array<double, 4>& quaternion, const cv::Vec3d& translation,
                                   const Origin& origin, const char* key);

[[nodiscard]] cv::Matx44d rigid_of(const cv::Matx33d& rotation, const cv::Vec3d& translation);

[[nodiscard]] cv::Matx44d inverse(const cv::Matx44d& rigid);

/// The calibration of both images turned by 180° and exchanged. Width and height of the rig are set.
void turn_upside_down(Calibration& calibration, const Origin& origin);

/// Rectifying rotations of a raw pair, and the resulting camera.
struct Rectification {
  Rig rig;  ///< the mount at its defaults
  cv::Mat left_turn;
  cv::Mat right_turn;
  cv::Matx33d camera;  ///< camera of both, after rectification
};

/// Undistorted cameras with parallel axes and equal focal lengths and cy: their images differ from those of a rectified
/// pair by cx_left − cx_right at most.
[[nodiscard]] bool is_row_aligned(const RawPair& raw);

/// Row-aligned pairs keep the left camera; the right image is shifted. Others: as OpenCV's stereoRectify with equal
/// centres and as little black at the edges as possible; of fisheye lenses at most 120° across remain. Throws
/// InputError: no baseline along x, lenses of two kinds.
[[nodiscard]] Rectification rectify(const RawPair& raw, int width_px, int height_px);

/// Both maps of cv::remap, rectified to raw.
void make_maps(const CameraModel& raw, const cv::Mat& turn, const Rectification& to, cv::Mat& map, cv::Mat& fractions);

}  // namespace stereogrid::io
