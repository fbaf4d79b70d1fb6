// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid {

/// Position in an image, px; pixel centres are at integers.
struct ImagePoint {
  double u{0};
  double v{0};
};

/// Mapping between camera images and level images. Images of a camera with a pitch above 1° are rotated about the
/// baseline before they are matched. FrameResult::stages and FrameResult::ground belong to the level images and their
/// rig. The mapping is the same for the left and the right image, and the identity for other rigs.
class STEREOGRID_EXPORT LevelMapping {
 public:
  explicit LevelMapping(const Rig& rig);

  /// True if camera images and level images are the same.
  [[nodiscard]] bool is_identity() const { return is_identity_; }
  /// Rig of the level images: pitch 0 if they are rotated. The centre's row and the image's height are chosen so that
  /// the image has the visible rows, at most 1.5 times the camera's (the farthest ones); its centre may lie outside.
  /// All else as given.
  [[nodiscard]] const Rig& level_rig() const { return level_rig_; }
  /// Point of the level image for `in_camera`, which may be outside of the image; none: behind the level camera.
  [[nodiscard]] std::optional<ImagePoint> level_from_camera(ImagePoint in_camera) const;
  /// The inverse; none: behind the camera.
  [[nodiscard]] std::optional<ImagePoint> camera_from_level(ImagePoint in_level) const;

 private:
  bool is_identity_;
  Rig camera_rig_;
  Rig level_rig_;
  double sin_pitch_;
  double cos_pitch_;
};

}  // namespace stereogrid
