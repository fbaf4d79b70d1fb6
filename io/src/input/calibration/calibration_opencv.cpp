// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
namespace {

CameraModel camera_of(const YamlGroup& file, const char* matrix, const char* distortion) {
  CameraModel camera{io::camera_of(file.matrix(matrix, 3, 3), file, matrix)};
  camera.distortion = file.vector(distortion);
  check_camera(camera, file);
  return camera;
}

}  // namespace

Calibration read_opencv_calibration(const YamlGroup& intrinsics, const YamlGroup& extrinsics,
                                    const CalibrationRequest& request) {
  Calibration calibration;
  calibration.kind = "OpenCV stereo calibration";
  RawPair raw;
  raw.left = camera_of(intrinsics, "M1", "D1");
  raw.right = camera_of(intrinsics, "M2", "D2");
  const std::vector<double> t{extrinsics.vector("T")};
  if (t.size() != 3) extrinsics.fail("has in 'T' a translation that is not 3 numbers.");
  set_transform(raw, rotation_of(extrinsics.matrix("R", 3, 3), extrinsics, "R"), {t[0], t[1], t[2]});
  calibration.raw = raw;
  take_unit(calibration, extrinsics, request);
  take_rig_of_raw(calibration, extrinsics, request);
  return calibration;
}

}  // namespace stereogrid::io
