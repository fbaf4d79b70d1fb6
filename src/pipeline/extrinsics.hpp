// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "stereogrid/camera.hpp"

namespace stereogrid {

/// Extrinsics of the rig as a ground plane.
inline Ground extrinsics_of(const Rig& rig) {
  return {rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad};
}

/// The rig with `ground` as extrinsics.
inline Rig with_extrinsics(Rig rig, const Ground& ground) {
  rig.camera_height_m = ground.height_m;
  rig.camera_pitch_rad = ground.pitch_rad;
  rig.camera_roll_rad = ground.roll_rad;
  return rig;
}

/// Rig with the extrinsics rounded to the digits of extrinsics_message(), so that a calibration with them gives the
/// same results.
inline Rig as_written(Rig rig) {
  const auto rounded = [](double number, double steps) { return std::round(number * steps) / steps + 0.0; };
  rig.camera_height_m = rounded(rig.camera_height_m, 1e3);
  rig.camera_pitch_rad = rounded(rig.camera_pitch_rad, 1e4);
  rig.camera_roll_rad = rounded(rig.camera_roll_rad, 1e4);
  return rig;
}

/// Message about estimated extrinsics, with the line for calibration.yaml.
inline std::string extrinsics_message(const Rig& rig) {
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                "the extrinsics are estimated from the images. "
                "For calibration.yaml: mount: {camera_height_m: %.3f, camera_pitch_rad: %.4f, camera_roll_rad: %.4f}",
                rig.camera_height_m, rig.camera_pitch_rad, rig.camera_roll_rad);
  return text.data();
}

}  // namespace stereogrid
