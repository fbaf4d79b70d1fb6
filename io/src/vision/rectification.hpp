// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>

#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// How the cameras of a raw pair are turned, and what they see then.
struct Rectification {
  Rig rig;  ///< the mount at its defaults
  cv::Mat left_turn;
  cv::Mat right_turn;
  cv::Matx33d camera;  ///< of both, after rectification
};

/// True for cameras without distortion that are turned alike and stand side by side, with one focal length and one
/// centre along v: a rectified pair, but for a constant offset of its disparities.
[[nodiscard]] bool differs_in_centre_u_only(const RawPair& raw);

/// As OpenCV's stereoRectify with equal centres and as little black at the edges as possible; of fisheye lenses at most
/// 120° across remain. A pair that differs in the centre along u only keeps its left image. Throws InputError: no
/// baseline along x, lenses of two kinds.
[[nodiscard]] Rectification rectify(const RawPair& raw, int width_px, int height_px);

/// Both maps of cv::remap, rectified to raw.
void make_maps(const CameraModel& raw, const cv::Mat& turn, const Rectification& to, cv::Mat& map, cv::Mat& fractions);

}  // namespace stereogrid::io
