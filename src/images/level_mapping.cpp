// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/level_mapping.hpp"

#include <cmath>

#include "images/turned_row.hpp"

namespace stereogrid {
namespace {

/// Pitch beyond which images are levelled, 1°.
constexpr double levelling_pitch_rad{0.017453292519943295};

std::optional<ImagePoint> turned(const Rig& rig, double sin_angle, double cos_angle, ImagePoint point) {
  const TurnedRow row{rig, sin_angle, cos_angle, point.v};
  if (!(row.depth > 0)) return std::nullopt;
  return ImagePoint{row.u_of(point.u), row.v};
}

}  // namespace

LevelMapping::LevelMapping(const Rig& rig)
    : is_identity_{!(std::abs(rig.camera_pitch_rad) > levelling_pitch_rad)},
      level_rig_{rig},
      sin_pitch_{std::sin(rig.camera_pitch_rad)},
      cos_pitch_{std::cos(rig.camera_pitch_rad)} {
  if (!is_identity_) level_rig_.camera_pitch_rad = 0;
}

std::optional<ImagePoint> LevelMapping::level_from_camera(ImagePoint in_camera) const {
  if (is_identity_) return in_camera;
  return turned(level_rig_, -sin_pitch_, cos_pitch_, in_camera);
}

std::optional<ImagePoint> LevelMapping::camera_from_level(ImagePoint in_level) const {
  if (is_identity_) return in_level;
  return turned(level_rig_, sin_pitch_, cos_pitch_, in_level);
}

}  // namespace stereogrid
