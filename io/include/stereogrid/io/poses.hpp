// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/frame.hpp"

namespace stereogrid::io {

/// A line of poses.csv.
struct NamedPose {
  std::string name;
  std::int64_t stamp_ns{0};
  Pose2 world_from_vehicle;
};

/// A camera's pose, world_from_camera 3 × 4 row-major (x right, y down, z forward), on the ground: x forward, y left,
/// heading of the optical axis.
[[nodiscard]] Pose2 on_the_ground(std::span<const double, 12> world_from_camera);

// Poses are relative to the file's own world, not to the first frame. Readers throw InputError and name the line.

/// KITTI's pose file: 12 numbers a line, world_from_camera 3 × 4 row-major (x right, y down, z forward), projected on
/// the ground: x forward, y left, heading of the optical axis. Complains of numbers that are not finite, of lines that
/// are no rotation, and where there are not `expected` of them.
[[nodiscard]] std::vector<Pose2> read_kitti_poses(const std::filesystem::path& path, std::size_t expected);

/// Our poses.csv: header name,stamp_ns,x_m,y_m,yaw_rad. Complains of double names and of stamps that do not grow.
[[nodiscard]] std::vector<NamedPose> read_poses_csv(const std::filesystem::path& path);

void write_poses_csv(const std::filesystem::path& path, std::span<const NamedPose> poses);

/// GPS/IMU records of a KITTI raw drive.
struct OxtsPoses {
  std::vector<Pose2> world_from_vehicle;  ///< one per name; world: x east, y north, Mercator as in KITTI's devkit
  bool of_camera{false};                  ///< moved to the left camera; false: of the IMU, calibration files missing
};

/// Reads FOLDER/NAME.txt (lat lon alt roll pitch yaw …) for each name. `calibration_folder` holds
/// calib_imu_to_velo.txt, calib_velo_to_cam.txt, calib_cam_to_cam.txt where they are known.
[[nodiscard]] OxtsPoses read_oxts(const std::filesystem::path& folder, std::span<const std::string> names,
                                  const std::filesystem::path& calibration_folder);

/// The pose file of a folder: poses.csv, poses_gt.txt, poses.txt, poses_vo.txt, then any other poses*.txt.
struct PoseChoice {
  std::filesystem::path file;
  std::vector<std::filesystem::path> others;  ///< also there, not taken
};
[[nodiscard]] std::optional<PoseChoice> find_poses(const std::filesystem::path& folder);

}  // namespace stereogrid::io
