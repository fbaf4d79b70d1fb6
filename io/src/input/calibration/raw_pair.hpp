// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/matx.hpp>
#include <vector>

#include "input/calibration/calibration_forms.hpp"
#include "input/origin.hpp"
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

}  // namespace stereogrid::io
