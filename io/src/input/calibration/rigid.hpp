// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "input/origin.hpp"

namespace stereogrid::io {

/// A rigid transform of 12 or 16 numbers, row-major. Throws InputError: no rotation, transposed.
[[nodiscard]] cv::Matx44d rigid_of(const std::vector<double>& numbers, const Origin& origin, const char* key);

/// From a quaternion x y z w of length 1 (to 1 %). Throws InputError.
[[nodiscard]] cv::Matx44d rigid_of(const std::array<double, 4>& quaternion, const cv::Vec3d& translation,
                                   const Origin& origin, const char* key);

[[nodiscard]] cv::Matx44d rigid_of(const cv::Matx33d& rotation, const cv::Vec3d& translation);

[[nodiscard]] cv::Matx44d inverse(const cv::Matx44d& rigid);

}  // namespace stereogrid::io
