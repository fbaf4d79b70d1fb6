// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/calibration.hpp"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/core/matx.hpp>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"
#include "input/poses/kitti_text.hpp"
#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/paths.hpp"
#include "stereogrid/io/text.hpp"

namespace stereogrid::io {
namespace {

constexpr double most_px{100'000};
constexpr double farthest_lidar_m{1000};

const char* const use_right_file{"Correct it, or name another file with --calibration."};

std::string text_of(double number) {
  return fmt::format("{:.6g}", number);
}

/// The optical part of a pair from two 3 × 4 projection matrices, row-major.
void take_projections(Calibration& calibration, const std::string& file, const std::vector<double>& left,
                      const std::vector<double>& right) {
  if (std::abs(left[0] - left[5]) > 0.01 * std::abs(left[0])) {
    throw InputError{file, "has focal lengths " + text_of(left[0]) + " and " + text_of(left[5]) + " px along u and v.",
                     "A rectified pair has one; use the rectified projections."};
  }
  const auto differ{[&](std::size_t i) { return std::abs(left[i] - right[i]) > 0.01; }};
  if (differ(0) || differ(5) || differ(6)) {
    throw InputError{file, "gives the two cameras different focal lengths or rows (cy).",
                     "A rectified pair has them alike; use the rectified projections."};
  }
  constexpr double shortest_m{0.02};
  if (const double shift{left[3] - right[3]}; shift >= shortest_m && shift < 1e-3 * left[0]) {
    throw InputError{file,
                     "has " + text_of(right[3]) + " in the right projection, as if it were the baseline in metres.",
                     "It is −f·baseline, here " + text_of(-shift * left[0]) + "."};
  }
  Rig rig;
  rig.focal_px = left[0];
  rig.cx_px = left[2];
  rig.cy_px = left[6];
  rig.baseline_m = left[0] > 0 ? (left[3] - right[3]) / left[0] : 0;
  take_row_aligned(calibration, rig, right[2]);
}

Transform transform_of(const std::string& file, const cv::Matx44d& matrix) {
  const double away_m{std::hypot(matrix(0, 3), matrix(1, 3), matrix(2, 3))};
  if (!(away_m <= farthest_lidar_m)) {
    throw InputError{file, "puts the lidar " + text_of(away_m) + " m away from the camera.",
                     "Correct it: its transform is in metres."};
  }
  if (!is_rotation(matrix.get_minor<3, 3>(0, 0))) {
    throw InputError{file, "has a transform of the lidar that is not a rotation.", use_right_file};
  }
  Transform transform{};
  for (int i{0}; i < 12; ++i) transform[static_cast<std::size_t>(i)] = matrix(i / 4, i % 4);
  return transform;
}

/// Moves the camera of a projection matrix P = K·[I | t] to its own centre: point_there = point_cam0 + t.
cv::Matx44d camera_from_cam0(const std::vector<double>& p) {
  const double z{p[11]};
  return {1, 0, 0, (p[3] - p[2] * z) / p[0], 0, 1, 0, (p[7] - p[6] * z) / p[5], 0, 0, 1, z, 0, 0, 0, 1};
}

Calibration read_odometry(const std::filesystem::path& path, const KittiText& text, KittiPair pair) {
  const bool has_colour_alone{!text.has("P0") && !text.has("P1") && text.has("P3")};
  const bool is_grey_pair{pair == KittiPair::grey && !has_colour_alone};
  const auto& left{text.get(is_grey_pair ? "P0" : "P2", 12)};
  const auto& right{text.get(is_grey_pair ? "P1" : "P3", 12)};
  Calibration calibration;
  calibration.kind = "KITTI odometry";
  if (has_colour_alone) calibration.notes.emplace_back("cameras: P2 and P3; the file has no P0 and P1");
  take_projections(calibration, printable_path(path), left, right);
  for (const char* const key : {"Tr", "Tr_velo_cam", "Tr_velo_to_cam"}) {
    if (!text.has(key)) continue;
    cv::Matx44d cam0_from_velodyne{text.transform(key)};
    if (text.has("R0_rect")) {  // object benchmark: the transform ends in the camera before rectification
      const auto& r{text.get("R0_rect", 9)};
      cam0_from_velodyne =
          cv::Matx44d{r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1} * cam0_from_velodyne;
    }
    calibration.camera_from_velodyne = transform_of(printable_path(path), camera_from_cam0(left) * cam0_from_velodyne);
  }
  return calibration;
}

/// Numbers of the cameras in P_rect_….
struct RectifiedCameras {
  const char* left;
  const char* right;
};
constexpr RectifiedCameras grey_cameras{"00", "01"};
constexpr RectifiedCameras colour_cameras{"02", "03"};
constexpr RectifiedCameras driving_stereo_cameras{"101", "103"};

Calibration read_raw_drive(const std::filesystem::path& path, const KittiText& text, const RectifiedCameras& cameras) {
  const std::string left_key{cameras.left};
  const auto& left{text.get("P_rect_" + left_key, 12)};
  const auto& right{text.get(std::string{"P_rect_"} + cameras.right, 12)};
  Calibration calibration;
  calibration.kind = "KITTI raw";
  take_projections(calibration, printable_path(path), left, right);
  if (text.has("S_rect_" + left_key)) {
    const auto& size{text.get("S_rect_" + left_key, 2)};
    if (!(size[0] >= 1 && size[0] <= most_px && size[1] >= 1 && size[1] <= most_px)) {
      throw InputError{printable_path(path), "has an image size in line 'S_rect_" + left_key + "' that is none.",
                       use_right_file};
    }
    calibration.rig.width_px = static_cast<int>(std::lround(size[0]));
    calibration.rig.height_px = static_cast<int>(std::lround(size[1]));
  }
  const auto velodyne{path.parent_path() / "calib_velo_to_cam.txt"};
  if (is_there(velodyne)) {
    const auto& r{text.get("R_rect_00", 9)};
    const cv::Matx44d rectified{r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1};
    calibration.camera_from_velodyne = transform_of(
        printable_path(velodyne), camera_from_cam0(left) * rectified * KittiText{velodyne}.rotation_and_translation());
  }
  return calibration;
}

}  // namespace

Calibration read_kitti_calibration(const std::filesystem::path& path, KittiPair pair) {
  const KittiText text{path};
  if (text.has("P_rect_101")) return read_raw_drive(path, text, driving_stereo_cameras);
  if (text.has("P_rect_00") || text.has("P_rect_02")) {
    return read_raw_drive(path, text, pair == KittiPair::grey ? grey_cameras : colour_cameras);
  }
  if (text.has("P0") || text.has("P2") || text.has("P1")) return read_odometry(path, text, pair);
  throw InputError{printable_path(path), "is not a calibration that is known.",
                   "docs/input.md has the formats that are read; KITTI's calib.txt has P0 and P1."};
}

Calibration read_calibration(const std::filesystem::path& path, const CalibrationRequest& request) {
  Calibration calibration{read_form({path}, request)};
  fit_to_images(calibration, printable_path(path), request.width_px, request.height_px);
  std::string all;
  for (const std::string& problem : problems(calibration.rig)) all += (all.empty() ? "" : " ") + problem;
  if (!all.empty()) throw InputError{printable_path(path), all, use_right_file};
  return calibration;
}

Calibration read_calibration(const std::filesystem::path& path, int width_px, int height_px, KittiPair pair) {
  return read_calibration(path, CalibrationRequest{width_px, height_px, pair});
}

Calibration read_depth_calibration(const std::filesystem::path& path, int width_px, int height_px) {
  CalibrationRequest request{width_px, height_px};
  request.has_depth = true;
  return read_calibration(path, request);
}

namespace {

/// Keys of the camera's place in the vehicle frame; empty at its origin.
std::string place_keys(const Rig& rig) {
  if (camera_place(rig) == Pose2{}) return "";
  return fmt::format(", camera_x_m: {}, camera_y_m: {}, camera_yaw_rad: {}", rig.camera_x_m, rig.camera_y_m,
                     rig.camera_yaw_rad);
}

}  // namespace

std::string mount_line(const Rig& rig) {
  return fmt::format("mount: {{camera_height_m: {:.3f}, camera_pitch_rad: {:.4f}, camera_roll_rad: {:.4f}{}}}",
                     rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad, place_keys(rig));
}

void write_calibration_yaml(const std::filesystem::path& path, const Rig& rig) {
  const std::string text{
      fmt::format("# rectified pair, left image is the reference\n"
                  "image: {{width_px: {}, height_px: {}}}\n"
                  "focal_px: {}\ncx_px: {}\ncy_px: {}\nbaseline_m: {}\n"
                  "mount: {{camera_height_m: {}, camera_pitch_rad: {}, camera_roll_rad: {}{}}}\n",
                  rig.width_px, rig.height_px, rig.focal_px, rig.cx_px, rig.cy_px, rig.baseline_m, rig.camera_height_m,
                  rig.camera_pitch_rad, rig.camera_roll_rad, place_keys(rig))};
  write_file(path, text);
}

void write_cameras_yaml(const std::filesystem::path& path, std::span<const std::string> folders) {
  write_file(path, fmt::format("# stereo pairs of one vehicle, each in a folder with its calibration.yaml\n"
                               "cameras: [{}]\n",
                               fmt::join(folders, ", ")));
}

}  // namespace stereogrid::io
