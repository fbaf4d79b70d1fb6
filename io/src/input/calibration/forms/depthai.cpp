// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

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

}  // namespace stereogrid::io
