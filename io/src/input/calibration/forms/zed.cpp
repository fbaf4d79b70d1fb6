// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>

#include "input/calibration/calibration_forms.hpp"
#include "input/calibration/raw_pair.hpp"

namespace stereogrid::io {
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
