// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/core/matx.hpp>

#include "input/poses/kitti_text.hpp"
#include "input/poses/recording_poses.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/poses.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

namespace fs = std::filesystem;

struct Record {
  double latitude_deg, longitude_deg, altitude_m, roll_rad, pitch_rad, yaw_rad;
};

Record read_record(const fs::path& path) {
  const char* const mend{"Use the drive's own oxts folder, or run with --poses none."};
  const std::string text{read_text(path, largest_bytes::calibration)};
  std::vector<double> n;
  if (!parse_numbers(text, n) || n.size() < 6) {
    throw InputError{printable_path(path), "does not hold the numbers lat lon alt roll pitch yaw.", mend};
  }
  for (std::size_t i{0}; i < 6; ++i) {
    if (!std::isfinite(n[i])) throw InputError{printable_path(path), "has a number that is not finite.", mend};
  }
  if (std::abs(n[0]) > 89) throw InputError{printable_path(path), fmt::format("has latitude {}.", n[0]), mend};
  if (std::abs(n[1]) > 360) throw InputError{printable_path(path), fmt::format("has longitude {}.", n[1]), mend};
  if (std::abs(n[2]) > 1e5) throw InputError{printable_path(path), fmt::format("has altitude {} m.", n[2]), mend};
  constexpr double largest_rad{2 * std::numbers::pi + 0.01};
  for (std::size_t i{3}; i < 6; ++i) {
    if (std::abs(n[i]) <= largest_rad) continue;
    throw InputError{printable_path(path), fmt::format("has an angle of {} rad (allowed −2π to 2π).", n[i]),
                     std::string{"Roll, pitch and yaw are in radians. "} + mend};
  }
  return {n[0], n[1], n[2], n[3], n[4], n[5]};
}

/// Pose of the IMU (x forward, y left, z up) in the Mercator plane of KITTI's devkit (x east, y north, z up).
cv::Matx44d world_from_imu(const Record& r, double scale) {
  constexpr double earth_radius_m{6378137};
  constexpr double degree{std::numbers::pi / 180};
  const double east{scale * earth_radius_m * degree * r.longitude_deg};
  const double north{scale * earth_radius_m * std::log(std::tan((90 + r.latitude_deg) * degree / 2))};
  const auto [cx, sx]{std::pair{std::cos(r.roll_rad), std::sin(r.roll_rad)}};
  const auto [cy, sy]{std::pair{std::cos(r.pitch_rad), std::sin(r.pitch_rad)}};
  const auto [cz, sz]{std::pair{std::cos(r.yaw_rad), std::sin(r.yaw_rad)}};
  return {cz * cy,
          cz * sy * sx - sz * cx,
          cz * sy * cx + sz * sx,
          east,
          sz * cy,
          sz * sy * sx + cz * cx,
          sz * sy * cx - cz * sx,
          north,
          -sy,
          cy * sx,
          cy * cx,
          r.altitude_m,
          0,
          0,
          0,
          1};
}

cv::Matx44d inverse_of(const cv::Matx44d& rigid) {
  const cv::Matx33d turned_back{rigid.get_minor<3, 3>(0, 0).t()};
  const cv::Vec3d t{turned_back * cv::Vec3d{rigid(0, 3), rigid(1, 3), rigid(2, 3)}};
  const cv::Matx33d& r{turned_back};
  return {r(0, 0), r(0, 1), r(0, 2), -t[0], r(1, 0), r(1, 1), r(1, 2), -t[1],
          r(2, 0), r(2, 1), r(2, 2), -t[2], 0,       0,       0,       1};
}

/// None: a calibration file is missing.
std::optional<cv::Matx44d> imu_from_camera(const fs::path& folder) {
  const auto imu{folder / "calib_imu_to_velo.txt"};
  const auto velodyne{folder / "calib_velo_to_cam.txt"};
  const auto camera{folder / "calib_cam_to_cam.txt"};
  for (const auto& file : {imu, velodyne, camera}) {
    if (!is_file(file)) return std::nullopt;
  }
  const auto r{KittiText{camera}.get("R_rect_00", 9)};
  const cv::Matx44d rectified{r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1};
  const cv::Matx44d camera_from_imu{rectified * KittiText{velodyne}.rotation_and_translation() *
                                    KittiText{imu}.rotation_and_translation()};
  if (!is_rotation(camera_from_imu.get_minor<3, 3>(0, 0))) {
    throw InputError{fmt::format("{}, {}, {}", printable_path(imu), printable_path(velodyne), printable_path(camera)),
                     "R or R_rect_00 is not a rotation matrix.",
                     "Use the calibration files of this recording, or run with --poses none."};
  }
  return inverse_of(camera_from_imu);
}

}  // namespace

OxtsPoses read_oxts(const fs::path& folder, std::span<const std::string> names, const fs::path& calibration_folder) {
  const std::optional<cv::Matx44d> imu_from_left{imu_from_camera(calibration_folder)};
  OxtsPoses poses;
  poses.of_camera = imu_from_left.has_value();
  double scale{0};  // scale of the first record: one plane for the drive
  for (const std::string& name : names) {
    const auto file{folder / (name + ".txt")};
    if (!is_file(file)) {
      throw InputError{printable_path(file), "the record of frame " + name + " is missing.",
                       "Complete the oxts folder, or run with --poses none."};
    }
    const Record record{read_record(file)};
    if (scale == 0) scale = std::cos(record.latitude_deg * std::numbers::pi / 180);
    const cv::Matx44d imu{world_from_imu(record, scale)};
    const cv::Matx44d m{imu_from_left ? imu * *imu_from_left : imu};
    const int forward{imu_from_left ? 2 : 0};  // forward is z of the camera, x of the IMU
    poses.world_from_vehicle.push_back({m(0, 3), m(1, 3), std::atan2(m(1, forward), m(0, forward))});
  }
  return poses;
}

OxtsTimes read_oxts_times(const fs::path& folder) {
  const fs::path file{folder.parent_path() / "timestamps.txt"};
  OxtsTimes times;
  if (!is_file(file)) return times;
  const auto stamps{
      read_timestamps(file, "Correct it, or remove the file: records belong to images of the same name then.")};
  std::map<std::size_t, std::string> records;
  for (const fs::path& entry : entries_of(folder)) {
    const std::string name{frame_name(entry.stem().string())};
    std::size_t number{0};
    const auto [end, error]{std::from_chars(name.data(), name.data() + name.size(), number)};
    if (entry.extension() == ".txt" && error == std::errc{} && *end == '\0') records.emplace(number, name);
  }
  for (const auto& [number, name] : records) {
    if (number >= stamps.size()) {
      throw InputError{printable_path(file), fmt::format("has {} stamps, none for record {}.", stamps.size(), name),
                       "Complete it, or remove the file: records belong to images of the same name then."};
    }
    times.names.push_back(name);
    times.stamps_ns.push_back(stamps[number]);
  }
  return times;
}

}  // namespace stereogrid::io
