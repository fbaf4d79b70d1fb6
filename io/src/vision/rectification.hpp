// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>

#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

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
