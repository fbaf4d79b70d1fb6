// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace stereogrid::app::testing {

/// Writes a drive of three frames in KITTI's odometry form over an empty road; the first and the last have a sweep. In
/// it every second one of the upper rings, the odd ones, meets a wall 8 m ahead, which the images do not show.
void put_lidar_drive(const std::filesystem::path& drive);

}  // namespace stereogrid::app::testing
