// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/level_mapping.hpp"

#include <cmath>

#include "images/levelling.hpp"

namespace stereogrid {
namespace {

/// Pitch beyond which images are levelled, 1°.
constexpr double levelling_pitch_rad{0.017453292519943295};

/// Rows of a level image to those of the camera's. More would be road right under the camera, seen at a glancing angle.
constexpr double rows_max{1.5};

std::optional<ImagePoint> turned(const Rig& rig, double turned_centre_v, double sin_angle, double cos_angle,
                                 ImagePoint point) {
  const TurnedRow row{rig, turned_centre_v, sin_angle, cos_angle, point.v};
  if (!(row.depth > 0)) return std::nullopt;
  return ImagePoint{row.u_of(point.u), row.v};
}

/// Centre and height so that the image holds the rows that the camera sees, `level` being that camera turned level.
void move_to_view(Rig& level, double sin_pitch, double cos_pitch) {
  const auto row_of = [&](double v, double behind) {
    const TurnedRow row{level, level.cy_px, -sin_pitch, cos_pitch, v};
    return row.depth > 0 ? row.v : behind;
  };
  const double most{rows_max * level.height_px};
  double first{std::floor(row_of(0, -1e9))};
  double end{std::ceil(row_of(level.height_px - 1, 1e9)) + 1};
  if (end - first > most) {
    // distant points are unchanged
    if (sin_pitch > 0) {
      end = std::floor(first + most);
    } else {
      first = std::ceil(end - most);
    }
  }
  level.cy_px -= first;
  level.height_px = static_cast<int>(end - first);
}

}  // namespace

LevelMapping::LevelMapping(const Rig& rig)
    : is_identity_{!(std::abs(rig.camera_pitch_rad) > levelling_pitch_rad)},
      camera_rig_{rig},
      level_rig_{rig},
      sin_pitch_{std::sin(rig.camera_pitch_rad)},
      cos_pitch_{std::cos(rig.camera_pitch_rad)} {
  if (is_identity_) return;
  level_rig_.camera_pitch_rad = 0;
  move_to_view(level_rig_, sin_pitch_, cos_pitch_);
}

std::optional<ImagePoint> LevelMapping::level_from_camera(ImagePoint in_camera) const {
  if (is_identity_) return in_camera;
  return turned(camera_rig_, level_rig_.cy_px, -sin_pitch_, cos_pitch_, in_camera);
}

std::optional<ImagePoint> LevelMapping::camera_from_level(ImagePoint in_level) const {
  if (is_identity_) return in_level;
  return turned(level_rig_, camera_rig_.cy_px, sin_pitch_, cos_pitch_, in_level);
}

}  // namespace stereogrid
