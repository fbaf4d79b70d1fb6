// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "terrain/walk.hpp"

namespace stereogrid {

/// Ground, obstacle and face samples of a ring, relative to an expected elevation.
struct RingSamples {
  int ground{0};
  float ground_z{0};  ///< sum
  int above{0};
  float top{-1e3f};         ///< highest sample of an obstacle
  bool is_standing{false};  ///< the obstacle begins near the ground
  float face_top{-1e3f};    ///< highest upright sample over the surface
  float face_bottom{1e3f};
  int face{0};
};

/// One ring of a sector. `z` and `slope` describe the surface expected at the ring's middle.
struct RingView {
  RingView(const WalkInput& input, const SectorRows& sector, int index);

  [[nodiscard]] RingSamples gather(float z, float slope, float tolerance) const;
  [[nodiscard]] bool has_ground(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] bool has_obstacle(const RingSamples& samples, float z, float slope) const;
  /// First row, upwards, with a sample behind the expected ground and lower than `highest_z`; no_row: fewer than half
  /// of the ground's rows have one. `z_near`, `z_far`: elevation of the ground at both ends.
  [[nodiscard]] int row_through(float z_near, float z_far, float highest_z) const;
  [[nodiscard]] float predicted_rows(float z, float slope) const;
  [[nodiscard]] bool is_checked() const { return ring < in->checked_rings; }
  /// Noise of the height over the surface, m.
  [[nodiscard]] float sigma(float z, float slope) const {
    return in->camera.height_sigma(in->camera.height_m - z, slope, x, sigma_px);
  }

  const WalkInput* in;
  SectorRows rows;
  int ring;
  float begin_m;
  float end_m;
  float x;  ///< middle of the ring
  float sigma_px;
};

}  // namespace stereogrid
