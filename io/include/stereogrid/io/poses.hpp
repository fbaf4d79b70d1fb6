// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Largest absolute value of valid stamps: the difference of any two fits into 64 bits. 0: 1970.
constexpr std::int64_t largest_stamp_ns{4'000'000'000'000'000'000};

/// Largest absolute x and y of valid poses: more than twice around the earth.
constexpr double largest_position_m{1e8};

/// A line of poses.csv.
struct NamedPose {
  std::string name;  ///< name of the frame; empty in files without names
  std::int64_t stamp_ns{0};
  Pose2 world_from_vehicle;
};

/// The quaternion x, y, z, w with length 1. None: its length is below 0.99 or above 1.01, or not finite.
[[nodiscard]] STEREOGRID_EXPORT std::optional<std::array<double, 4>> unit_quaternion(
    const std::array<double, 4>& quaternion);

// Poses are relative to the file's own world, not to the first frame. Readers throw InputError and name the line.

/// KITTI's pose file: 12 numbers a line, world_from_camera 3 × 4 row-major (x right, y down, z forward), projected on
/// the ground: x forward, y left, heading of the optical axis. Throws
/// InputError: numbers that are not finite, no rotation, another number of lines than `expected`.
[[nodiscard]] STEREOGRID_EXPORT std::vector<Pose2> read_kitti_poses(const std::filesystem::path& path,
                                                                    std::size_t expected);

/// stereogrid's poses.csv: header name,stamp_ns,x_m,y_m,yaw_rad, or without names, for poses with times of their own.
/// Throws InputError: duplicate names, stamps that do not increase.
[[nodiscard]] STEREOGRID_EXPORT std::vector<NamedPose> read_poses_csv(const std::filesystem::path& path);

/// Writes a file for read_poses_csv(). Throws DeviceError.
STEREOGRID_EXPORT void write_poses_csv(const std::filesystem::path& path, std::span<const NamedPose> poses);

/// A pose and its instant.
struct StampedPose {
  std::int64_t stamp_ns{0};
  Pose2 world_from_vehicle;
};

/// Poses of a file in one of these forms. Poses are relative to the first one, on the ground.
struct Trajectory {
  std::vector<StampedPose> poses;
  bool are_of_body{false};             ///< body poses (x ahead, z up), since they move along x
  std::string note{};                  ///< another unit of the stamps than the form's; empty: the form's
  bool have_stamps{true};              ///< false: a line per frame, or `frames`
  std::vector<std::int64_t> frames{};  ///< number of the frame of each pose; empty: none
};

/// True: the first line that is no comment has the columns of one of the forms of read_trajectory().
[[nodiscard]] STEREOGRID_EXPORT bool is_trajectory(const std::filesystem::path& path);

/// Reads poses with comments behind #, separated by blanks or commas:
/// - TUM: "timestamp tx ty tz qx qy qz qw", stamps in seconds, world_from_camera (x right, y down, z forward) in any
///   world; those that move along their own x axis are a body's (x ahead, z up).
/// - EuRoC's ground truth: ns, position, quaternion w x y z of the body; `body_from_camera` (T_BS) transforms them to
/// the camera.
/// - AirSim's airsim_rec.txt: ms, position, quaternion w x y z of the vehicle (x ahead, y to the right, z down).
/// - TartanAir: position, quaternion x y z w of the camera in the same axes, a line per frame.
/// - KITTI-360: number of the frame, and world_from_camera as 4 × 4, or the vehicle as 3 × 4.
/// Stamps in s, ms, µs or ns are recognised by their step. Throws InputError: other columns, quaternions whose length
/// is not 1, stamps that do not increase.
[[nodiscard]] STEREOGRID_EXPORT Trajectory read_trajectory(const std::filesystem::path& path,
                                                           const std::optional<Transform>& body_from_camera = {});

/// Poses at other instants: linear interpolation of the position, heading along the shorter arc. Motion
/// is extrapolated up to one median interval before the first and after the last pose. `poses`: stamps increase.
/// Throws InputError naming `source`: an instant outside this range, or fewer than two poses.
[[nodiscard]] STEREOGRID_EXPORT std::vector<Pose2> interpolate_poses(const std::filesystem::path& source,
                                                                     std::span<const StampedPose> poses,
                                                                     std::span<const std::int64_t> stamps_ns);

/// GPS/IMU records of a KITTI raw drive.
struct OxtsPoses {
  std::vector<Pose2> world_from_vehicle;  ///< one per name; world: x east, y north, Mercator as in KITTI's devkit
  bool of_camera{false};                  ///< moved to the left camera; false: of the IMU, calibration files missing
};

/// Reads FOLDER/NAME.txt (lat lon alt roll pitch yaw …) for each name. `calibration_folder` holds
/// calib_imu_to_velo.txt, calib_velo_to_cam.txt, calib_cam_to_cam.txt where they are known.
[[nodiscard]] STEREOGRID_EXPORT OxtsPoses read_oxts(const std::filesystem::path& folder,
                                                    std::span<const std::string> names,
                                                    const std::filesystem::path& calibration_folder);

/// The names of all records in FOLDER, in their order, and the stamps that FOLDER/../timestamps.txt gives them by their
/// numbers (line i for record i). Empty: no such file.
struct OxtsTimes {
  std::vector<std::string> names;
  std::vector<std::int64_t> stamps_ns;
};
/// Reads the names and stamps of a folder's records. Throws InputError.
[[nodiscard]] STEREOGRID_EXPORT OxtsTimes read_oxts_times(const std::filesystem::path& folder);

/// The pose file of a folder: poses.csv, poses_gt.txt, poses.txt, poses_vo.txt, then any other poses*.txt,
/// then groundtruth.txt, trajectory.txt, CameraTrajectory.txt, pose_left.txt and airsim_rec.txt (read_trajectory).
struct PoseChoice {
  std::filesystem::path file;
  std::vector<std::filesystem::path> others;  ///< also there, not taken
};
/// Pose file of a folder; none: there is none.
[[nodiscard]] STEREOGRID_EXPORT std::optional<PoseChoice> find_poses(const std::filesystem::path& folder);

}  // namespace stereogrid::io
