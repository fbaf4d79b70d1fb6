// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"
#include "stereogrid/frame.hpp"

namespace stereogrid::io {

/// Lens models: OpenCV's usual model, or that of cv::fisheye (ROS and Kalibr: "equidistant").
enum class LensModel { perspective, fisheye };

/// One camera of a pair that is not rectified, as OpenCV models it.
struct CameraModel {
  double focal_u_px{0};
  double focal_v_px{0};
  double cx_px{0};
  double cy_px{0};
  std::vector<double> distortion;  ///< k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [τx τy]]]], fisheye: k1 k2 k3 k4; empty:
                                   ///< all 0
  LensModel lens{LensModel::perspective};
};

/// Two cameras that are not rectified. A point of the left camera's frame lies at R·p + t in the right camera's.
struct RawPair {
  CameraModel left;
  CameraModel right;
  std::array<double, 9> right_from_left_rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row-major 3 × 3
  std::array<double, 3> right_from_left_translation_m{0, 0, 0};
};

/// A 3 × 4 rigid transform, row-major.
using Transform = std::array<double, 12>;

struct Calibration {
  Rig rig;                                        ///< rectified pair; width and height 0 if the file has none
  std::optional<RawPair> raw;                     ///< there: images have to be rectified (Rectifier)
  std::optional<Transform> camera_from_velodyne;  ///< to the left rectified camera (x right, y down, z forward)
  std::string kind;                     ///< "calibration.yaml", "KITTI odometry", "KITTI raw", "ROS camera_info",
                                        ///< "OpenCV stereo calibration" or "Kalibr camchain"
  bool has_extrinsics{false};           ///< false: the rig's height is the usual one, its angles 0
  std::filesystem::path mask{};         ///< image for read_mask; empty: none
  std::map<int, PixelLabel> labels{};   ///< meaning of the values of label images; others have none
  std::vector<std::string> notes{};     ///< interpretation of the file where it is ambiguous
  std::vector<std::string> warnings{};  ///< values that are probably those of other images
  bool is_upside_down{false};           ///< 'rotate: 180': images are to be turned (open_recording)
  bool is_lens_unnamed{false};  ///< four distortion coefficients of `raw`, read as k1 k2 p1 p2, may be cv::fisheye's
};

/// Which cameras of a KITTI set are the pair.
enum class KittiPair { grey, colour };

/// Reads any of our calibration.yaml, KITTI odometry's calib.txt, KITTI raw's calib_cam_to_cam.txt (with
/// calib_velo_to_cam.txt beside it), a pair of ROS's camera_info files, OpenCV's intrinsics.yml and extrinsics.yml, and
/// Kalibr's camchain.yaml (docs/input.md), recognised by content. Of two files either may be named; the other is found
/// by its name. A raw pair that needs no rectification is returned as a rectified one. Files of other tools have no
/// extrinsics: height 1.65 m, pitch 0. `width_px`, `height_px`: size of the recording's images (fit_to_images), 0 =
/// unknown. Throws InputError with what is wrong: missing keys, `problems` of the rig, other image size, …
[[nodiscard]] STEREOGRID_EXPORT Calibration read_calibration(const std::filesystem::path& path, int width_px = 0,
                                                             int height_px = 0, KittiPair pair = KittiPair::grey);

/// Calibration of images with depth: one camera is enough, and without a baseline a virtual one is taken. Intrinsics of
/// one camera are read from JSON, YAML and XML, or as a matrix of 3 × 3, 3 × 4 or 4 × 4 numbers. Else as
/// read_calibration.
[[nodiscard]] STEREOGRID_EXPORT Calibration read_depth_calibration(const std::filesystem::path& path, int width_px = 0,
                                                                   int height_px = 0);

/// Baseline (m) at which a depth of half a metre is within any disparity search.
[[nodiscard]] STEREOGRID_EXPORT double virtual_baseline_m(double focal_px, int width_px);

/// Adapts a calibration to images of this size; 0: no effect. A calibration of another size is scaled where the ratio
/// is exact, and `notes` says so; a size of 0 becomes that of the images. `name`: the calibration's, for error
/// messages. Throws InputError: no exact ratio; without a size, a principal point far from the middle of the images.
STEREOGRID_EXPORT void fit_to_images(Calibration& calibration, const std::string& name, int width_px, int height_px);

/// Extrinsics of the rig as a line of calibration.yaml, to a millimetre and 0.0001 rad.
[[nodiscard]] STEREOGRID_EXPORT std::string mount_line(const Rig& rig);

/// Writes the rectified form of calibration.yaml. Throws DeviceError.
STEREOGRID_EXPORT void write_calibration_yaml(const std::filesystem::path& path, const Rig& rig);

/// Writes the calibration.yaml of a folder with several stereo pairs: the names of their folders. Throws DeviceError.
STEREOGRID_EXPORT void write_cameras_yaml(const std::filesystem::path& path, std::span<const std::string> folders);

/// One camera as ROS calibrates it (sensor_msgs/CameraInfo, REP 104). Matrices are row-major, lengths in pixels.
struct RosCamera {
  std::string name;  ///< source, for messages
  int width_px{0};   ///< size of the calibration's images
  int height_px{0};
  std::string distortion_model;  ///< plumb_bob, rational_polynomial or equidistant; "": plumb_bob
  std::vector<double> d;         ///< as many as the model has: 5 (or 4), 8 (or OpenCV's 12 or 14), 4
  std::array<double, 9> k{};     ///< camera matrix, before rectification
  std::array<double, 9> r{};     ///< takes points of the camera to those of the rectified camera
  std::array<double, 12> p{};    ///< projection after rectification; of the right camera p[3] = −p[0] · baseline (m)
};

/// Calibration from two messages. `are_rectified`: P applies to the images, and K, D and R are ignored. Otherwise they
/// are raw, and `raw` of the result describes the rectification, unless none is needed. Extrinsics are defaults: height
/// 1.65 m, angles 0. Throws InputError: no calibrated pair, non-finite numbers, an unsupported distortion model.
[[nodiscard]] STEREOGRID_EXPORT Calibration ros_calibration(const RosCamera& left, const RosCamera& right,
                                                            bool are_rectified);

}  // namespace stereogrid::io
