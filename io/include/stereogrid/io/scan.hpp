// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "stereogrid/export.hpp"

namespace stereogrid::io {

/// A lidar return in the sensor's own frame (Velodyne: x forward, y left, z up).
struct ScanPoint {
  float x_m{0};
  float y_m{0};
  float z_m{0};
  float reflectance{0};  ///< 0–1
};

/// Reads a lidar sweep in KITTI's form: little-endian float32 x, y, z, reflectance, one point after the other. Points
/// with a coordinate that is not finite (no return) are left out. Throws InputError: missing, empty, cut off within a
/// point, or nothing but such points.
[[nodiscard]] STEREOGRID_EXPORT std::vector<ScanPoint> read_scan(const std::filesystem::path& path);

}  // namespace stereogrid::io
