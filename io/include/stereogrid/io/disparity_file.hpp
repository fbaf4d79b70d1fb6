// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "stereogrid/export.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid::io {

/// Reads a disparity image (px of the left image; values that are not finite or not positive become 0 = none),
/// recognised by content. Formats: PNG of 16 bits in KITTI's coding (disparity × 256), PFM of one channel, TIFF of 32-
/// or 64-bit floats, NumPy .npy of float32 or float64 in shape (height, width). Throws InputError: missing, truncated
/// or damaged, another type, or values that are not px (most exceed the image's width, or none reaches 1 px).
[[nodiscard]] STEREOGRID_EXPORT Image<float> read_disparity(const std::filesystem::path& path);

/// Reads a depth image (along the camera's axis, m; values that are not finite or not positive become 0 = none): PNG or
/// TIFF of 16 bits, of which `units_per_m` are a metre; PFM, TIFF or .npy of floats in metres. Throws InputError as
/// read_disparity(), and where half of the values exceed 1000 m.
[[nodiscard]] STEREOGRID_EXPORT Image<float> read_depth(const std::filesystem::path& path, double units_per_m);

}  // namespace stereogrid::io
