// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <vector>

#include "input/calibration/yaml_group.hpp"
#include "stereogrid/io/calibration.hpp"

namespace stereogrid::io {

/// Information beside a calibration file.
struct CalibrationRequest {
  int width_px{0};  ///< size of the images, 0: unknown
  int height_px{0};
  KittiPair pair{KittiPair::grey};
  // named by a calibration.yaml with 'from'
  bool is_named{false};
  bool has_stated_size{false};  ///< width and height are those that it states
  std::optional<bool> images_are_raw{};
  std::optional<double> baseline_m{};
  std::optional<LensModel> lens{};   ///< lens of a file that names none
  std::array<int, 2> cameras{0, 1};  ///< the pair among the cameras of a Kalibr file
  bool has_depth{false};             ///< images with depth: one camera is enough
};

// Readers throw InputError: no such file, missing keys, invalid values or cameras. The caller checks `problems` of the
// rig.

/// Reads a file of any supported tool, or calibration.yaml, recognised by content. `paths`: one file, or left and
/// right.
[[nodiscard]] Calibration read_form(const std::vector<std::filesystem::path>& paths, const CalibrationRequest& request);

/// The same, checked and fitted to the images' size.
[[nodiscard]] Calibration read_calibration(const std::filesystem::path& path, const CalibrationRequest& request);

/// The keys of a file in any notation: YAML, JSON, OpenCV's XML, ZED's and Middlebury's texts, ost.txt.
[[nodiscard]] YamlGroup read_calibration_tree(const std::filesystem::path& path);

/// True: read_form() has a reader for the file. False where it cannot be read, too.
[[nodiscard]] bool is_calibration_of_other_tool(const std::filesystem::path& path, bool has_depth = false);

/// Either form of calibration.yaml, or one that names a file of another tool.
[[nodiscard]] Calibration read_own_calibration(const YamlGroup& root, const std::filesystem::path& path,
                                               const CalibrationRequest& request);
/// Intrinsics of one camera, for images with depth; none: the file has none.
[[nodiscard]] std::optional<Calibration> read_single_calibration(const YamlGroup& root,
                                                                 const CalibrationRequest& request);
[[nodiscard]] Calibration read_kitti_calibration(const std::filesystem::path& path, KittiPair pair);
[[nodiscard]] Calibration read_ros_calibration(const YamlGroup& left, const YamlGroup& right,
                                               const CalibrationRequest& request);
/// Which parts of OpenCV's stereoCalibrate a file has, under any of the usual names.
struct OpencvParts {
  bool has_intrinsics;
  bool has_extrinsics;
  bool has_projections;  ///< rectified pair without R and T: P1 and P2, or Q
};
[[nodiscard]] OpencvParts opencv_parts(const YamlGroup& root);
/// perspective or fisheye, as "fisheye", "equidistant", "kb4" or "pinhole", "plumb_bob", "radtan" name them; none:
/// another.
[[nodiscard]] std::optional<LensModel> lens_named(std::string_view word);
/// Both may be the same file.
[[nodiscard]] Calibration read_opencv_calibration(const YamlGroup& intrinsics, const YamlGroup& extrinsics,
                                                  const CalibrationRequest& request);
[[nodiscard]] Calibration read_opencv_projections(const YamlGroup& root, const CalibrationRequest& request);
[[nodiscard]] Calibration read_kalibr_calibration(const YamlGroup& root, const CalibrationRequest& request);

// forms/: a file per tool

[[nodiscard]] Calibration read_basalt_calibration(const YamlGroup& root, const CalibrationRequest& request);
[[nodiscard]] Calibration read_depthai_calibration(const YamlGroup& root, const CalibrationRequest& request);
/// sensor.yaml of both cameras of an ASL folder (EuRoC).
[[nodiscard]] Calibration read_euroc_calibration(const YamlGroup& cam0, const YamlGroup& cam1,
                                                 const CalibrationRequest& request);
/// calib.txt of Middlebury's and ETH3D's pairs.
[[nodiscard]] Calibration read_middlebury_calibration(const YamlGroup& root, const CalibrationRequest& request);
/// Settings of ORB-SLAM2 and ORB-SLAM3 for stereo cameras.
[[nodiscard]] Calibration read_orbslam_calibration(const YamlGroup& root, const CalibrationRequest& request);
/// stereoParameters of MATLAB, written with jsonencode(toStruct(…)).
[[nodiscard]] Calibration read_matlab_calibration(const YamlGroup& root, const CalibrationRequest& request);
/// Configuration of VINS-Fusion: body_T_cam0, body_T_cam1 and the names of both cameras' files.
[[nodiscard]] Calibration read_vins_calibration(const YamlGroup& root, const std::filesystem::path& path,
                                                const CalibrationRequest& request);
/// SN*.conf of a ZED camera.
[[nodiscard]] Calibration read_zed_calibration(const YamlGroup& root, const CalibrationRequest& request);
/// True: the file has the camera of VINS, without a baseline.
[[nodiscard]] bool is_vins_camera(const YamlGroup& root);

/// Two files that are named alike: with "left" and "right", or "intrinsic" and "extrinsic", in the name of the file,
/// else in that of its folder.
struct FilePair {
  std::filesystem::path first;
  std::filesystem::path second;
};

/// Left and right file, of which `either` is one. Throws InputError: the name has no counterpart, or it does not exist.
[[nodiscard]] FilePair left_and_right(const std::filesystem::path& either);

/// The same for OpenCV's intrinsics.yml and extrinsics.yml.
[[nodiscard]] FilePair intrinsics_and_extrinsics(const std::filesystem::path& either);

/// The second camera of a EuRoC folder is the left one, as both T_BS say. False where they cannot be read.
[[nodiscard]] bool is_cam0_right(const std::filesystem::path& cam0, const std::filesystem::path& cam1);

/// Calibration file of another tool in a folder: LEFT.yaml there, in camera_info/ or as left/camera_info.yaml or
/// left/ost.yaml, extrinsics.yml, camchain.yaml, or any file of a supported format, there or in calib/, calibration/ or
/// intrinsic/. `has_depth`: one camera is enough. Empty: none. Throws InputError where there are several.
[[nodiscard]] std::filesystem::path find_calibration_in(const std::filesystem::path& folder, bool has_depth = false);

/// Terms in messages about a camera.
struct RosTerms {
  const char* k;
  const char* d;
  const char* r;
  const char* p;
  const char* if_rectified;  ///< remedies for rectified images, and for a measured baseline: a
  const char* if_measured;   ///< sentence that begins with a blank; "": nothing
};

inline constexpr const char* calibrate_together{
    "Calibrate both cameras together (camera_calibration's cameracalibrator with two cameras), and use its left and "
    "right file."};

struct RosSide {
  const RosCamera& camera;
  const Origin& origin;
};

/// Rig of rectified images, or a raw pair whose rig has its size only. `has_given_baseline`: replaces the baseline
/// here, which may then be zero. Throws InputError.
[[nodiscard]] Calibration ros_pair(const RosSide& left, const RosSide& right, const RosTerms& terms, bool are_rectified,
                                   bool has_given_baseline);

}  // namespace stereogrid::io
