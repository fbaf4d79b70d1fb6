// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

using Cameras = std::vector<YamlGroup::Element>;

constexpr double cm{0.01};

const YamlGroup* camera_at(const Cameras& cameras, int socket) {
  const auto found{std::ranges::find(cameras, std::to_string(socket), &YamlGroup::Element::name)};
  return found == cameras.end() ? nullptr : &found->group;
}

const YamlGroup& required(const Cameras& cameras, int socket, const YamlGroup& root) {
  const YamlGroup* const camera{camera_at(cameras, socket)};
  if (camera == nullptr) {
    root.fail(fmt::format("has no camera of socket {} in 'cameraData'.", socket),
              "Dump the calibration of a stereo device.");
  }
  return *camera;
}

/// To the camera at the end of the chain of extrinsics; the last socket is stored in `socket`.
cv::Matx44d transform_to_end(const Cameras& cameras, int& socket, int until) {
  constexpr int longest_chain{8};
  cv::Matx44d end_from_camera{cv::Matx44d::eye()};
  for (int i{0}; i < longest_chain && socket != until; ++i) {
    const YamlGroup* const camera{camera_at(cameras, socket)};
    if (camera == nullptr || !camera->has("extrinsics")) break;
    const YamlGroup extrinsics{camera->group("extrinsics")};
    const int next{static_cast<int>(extrinsics.number("toCameraSocket"))};
    if (camera_at(cameras, next) == nullptr) break;
    const YamlGroup t{extrinsics.group("translation")};
    const cv::Vec3d shift_m{cm * t.number("x"), cm * t.number("y"), cm * t.number("z")};
    const std::vector<double> turn{extrinsics.numbers("rotationMatrix", 9)};
    end_from_camera = rigid_of(rotation_of(turn, extrinsics, "rotationMatrix"), shift_m) * end_from_camera;
    socket = next;
  }
  return end_from_camera;
}

cv::Matx44d right_from_left(const Cameras& cameras, int left, int right, const YamlGroup& root) {
  int end{left};
  const cv::Matx44d end_from_left{transform_to_end(cameras, end, right)};
  if (end == right) return end_from_left;
  int other_end{right};
  const cv::Matx44d end_from_right{transform_to_end(cameras, other_end, left)};
  if (other_end != end && other_end != left) {
    root.fail(fmt::format("has no extrinsics that lead from camera {} to camera {}.", left, right),
              "Dump the calibration of a calibrated stereo device.");
  }
  return other_end == left ? inverse(end_from_right) : inverse(end_from_right) * end_from_left;
}

CameraModel model_of(const YamlGroup& camera) {
  CameraModel model{camera_of(camera.numbers("intrinsicMatrix", 9), camera, "intrinsicMatrix")};
  model.distortion = camera.numbers("distortionCoeff");
  if (camera.has("cameraType") && camera.number("cameraType") == 1) {
    model.lens = LensModel::fisheye;
    model.distortion.resize(4);
  }
  return model;
}

}  // namespace

Calibration read_depthai_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  const Cameras cameras{root.groups("cameraData")};
  int left{1};
  int right{2};
  if (root.has("stereoRectificationData")) {
    const YamlGroup sockets{root.group("stereoRectificationData")};
    left = static_cast<int>(sockets.number("leftCameraSocket", left));
    right = static_cast<int>(sockets.number("rightCameraSocket", right));
    if (camera_at(cameras, left) == nullptr || camera_at(cameras, right) == nullptr) left = 1, right = 2;
  }
  const YamlGroup& left_camera{required(cameras, left, root)};
  const YamlGroup& right_camera{required(cameras, right, root)};
  Calibration calibration;
  calibration.kind = "DepthAI calibration";
  calibration.rig.width_px = left_camera.pixels("width");
  calibration.rig.height_px = left_camera.pixels("height");
  if (right_camera.pixels("width") != calibration.rig.width_px ||
      right_camera.pixels("height") != calibration.rig.height_px) {
    right_camera.fail("has another size than the left camera.", "Both cameras' images have the same size.");
  }
  take_pair(calibration, model_of(left_camera), model_of(right_camera), right_from_left(cameras, left, right, root),
            root, request);
  return calibration;
}

namespace {

struct Mode {
  const char* name;  ///< in the names of sections
  int width_px;
  int height_px;
};

// Modes of all models. Larger ones first: they are scaled down where the images' own mode has no section.
constexpr std::array<Mode, 8> modes{{{"4k", 3840, 2160},
                                     {"QHDPLUS", 3200, 1800},
                                     {"2K", 2208, 1242},
                                     {"FHD1200", 1920, 1200},
                                     {"FHD", 1920, 1080},
                                     {"HD", 1280, 720},
                                     {"SVGA", 960, 600},
                                     {"VGA", 672, 376}}};

std::string section_of(const char* side, const Mode& mode) {
  return fmt::format("{}_CAM_{}", side, mode.name);
}

/// The mode of the images' size, else the next larger one of their aspect, else the only one.
const Mode& mode_of(const YamlGroup& root, const CalibrationRequest& request) {
  const Mode* similar{nullptr};
  const Mode* only{nullptr};
  std::size_t count{0};
  for (const Mode& mode : modes) {
    if (!root.has(section_of("LEFT", mode).c_str())) continue;
    if (mode.width_px == request.width_px && mode.height_px == request.height_px) return mode;
    const bool has_aspect{mode.width_px * request.height_px == mode.height_px * request.width_px};
    if (has_aspect && (similar == nullptr || mode.width_px >= request.width_px)) similar = &mode;
    only = &mode;
    ++count;
  }
  if (request.width_px != 0 && similar != nullptr) return *similar;
  if (count == 1) return *only;
  root.fail(fmt::format("has {} sections LEFT_CAM_…, none for images of {}×{} px.", count, request.width_px,
                        request.height_px),
            "ZED's images have 2208×1242, 1920×1080, 1920×1200, 1280×720, 960×600 or 672×376 px.");
}

CameraModel camera_of(const YamlGroup& camera) {
  CameraModel model{camera.number("fx"), camera.number("fy"), camera.number("cx"), camera.number("cy"), {}};
  model.distortion = {camera.number("k1", 0), camera.number("k2", 0), camera.number("p1", 0), camera.number("p2", 0),
                      camera.number("k3", 0)};
  if (!camera.has("k4")) return model;
  for (const char* const key : {"k4", "k5", "k6"}) model.distortion.push_back(camera.number(key, 0));
  return model;
}

}  // namespace

Calibration read_zed_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  constexpr double mm{1e-3};
  const Mode& mode{mode_of(root, request)};
  const YamlGroup stereo{root.group("STEREO")};
  const auto angle{[&](const char* axis) { return stereo.number(fmt::format("{}_{}", axis, mode.name).c_str(), 0); }};
  const cv::Vec3d shift_m{-mm * stereo.number("Baseline"), mm * stereo.number("TY", 0), mm * stereo.number("TZ", 0)};
  Calibration calibration;
  calibration.kind = "ZED calibration";
  calibration.rig.width_px = mode.width_px;
  calibration.rig.height_px = mode.height_px;
  take_pair(calibration, camera_of(root.group(section_of("LEFT", mode).c_str())),
            camera_of(root.group(section_of("RIGHT", mode).c_str())),
            rigid_of(rotation_of({angle("RX"), angle("CV"), angle("RZ")}, stereo, "RX"), shift_m), stereo, request);
  return calibration;
}

}  // namespace stereogrid::io
