// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

/// kb4 is OpenCV's fisheye model, pinhole-radtan8 its rational one.
CameraModel camera_of(const YamlGroup& camera) {
  const std::string type{camera.word("camera_type")};
  const YamlGroup k{camera.group("intrinsics")};
  CameraModel model{k.number("fx"), k.number("fy"), k.number("cx"), k.number("cy"), {}};
  if (type == "kb4") {
    model.lens = LensModel::fisheye;
    model.distortion = {k.number("k1"), k.number("k2"), k.number("k3"), k.number("k4")};
  } else if (type == "pinhole-radtan8") {
    model.distortion = {k.number("k1"), k.number("k2"), k.number("p1"), k.number("p2"),
                        k.number("k3"), k.number("k4"), k.number("k5"), k.number("k6")};
  } else if (type != "pinhole") {
    camera.fail(fmt::format("has 'camera_type' {} (allowed: pinhole, pinhole-radtan8, kb4).", type),
                "Calibrate with --cam-types kb4 kb4.");
  }
  return model;
}

cv::Matx44d transform_of(const YamlGroup& pose) {
  return rigid_of({pose.number("qx"), pose.number("qy"), pose.number("qz"), pose.number("qw")},
                  {pose.number("px"), pose.number("py"), pose.number("pz")}, pose, "q");
}

}  // namespace

Calibration read_basalt_calibration(const YamlGroup& root, const CalibrationRequest& request) {
  const YamlGroup file{root.has("value0") ? root.group("value0") : root};
  const auto poses{file.groups("T_imu_cam")};
  const auto cameras{file.groups("intrinsics")};
  if (poses.size() < 2 || cameras.size() < 2) {
    file.fail(fmt::format("has {} cameras, not 2: it has no baseline.", std::min(poses.size(), cameras.size())),
              "Calibrate both cameras together.");
  }
  const std::vector<double> size{file.numbers("resolution")};
  if (size.size() < 4 || size[0] != size[2] || size[1] != size[3] || !(size[0] >= 1 && size[0] <= 1e5) ||
      !(size[1] >= 1 && size[1] <= 1e5)) {
    file.fail("has no 'resolution' that both cameras share.", "It is [[width, height], [width, height]].");
  }
  Calibration calibration;
  calibration.kind = "Basalt calibration";
  calibration.rig.width_px = static_cast<int>(size[0]);
  calibration.rig.height_px = static_cast<int>(size[1]);
  take_pair(calibration, camera_of(cameras[0].group), camera_of(cameras[1].group),
            inverse(transform_of(poses[1].group)) * transform_of(poses[0].group), file, request);
  return calibration;
}

}  // namespace stereogrid::io
