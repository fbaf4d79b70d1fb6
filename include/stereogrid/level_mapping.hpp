// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "stereogrid/camera.hpp"
#include "stereogrid/export.hpp"

namespace stereogrid {

/// A place in an image, px; pixel centres are at integers.
struct ImagePoint {
  double u{0};
  double v{0};
};

/// The images of a camera that is pitched by more than 1° are turned level, about the baseline, before they are
/// matched. FrameResult::stages and FrameResult::ground are of the level images and their rig; this takes places from
/// the one to the other, of the left image as of the right one. For other rigs both are the same.
class STEREOGRID_EXPORT LevelMapping {
 public:
  explicit LevelMapping(const Rig& rig);

  /// Are camera images and level images the same?
  [[nodiscard]] bool is_identity() const { return is_identity_; }
  /// The rig whose images the level ones are: pitch 0 where they are turned, and the centre's row and the image's
  /// height such that the image has the rows that the camera sees, at most half as many again as the camera's (those
  /// farthest away); its centre may lie outside it. All else as given.
  [[nodiscard]] const Rig& level_rig() const { return level_rig_; }
  /// Where the level image has what the camera's image has at `in_camera`, be it outside the image; none: behind the
  /// level camera.
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
