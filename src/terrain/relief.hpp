// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "ground/relief.hpp"
#include "held_bytes.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// The ground of all sectors as a Relief. Elevations that the noise explains are 0: level ground is the plane.
class TerrainRelief {
 public:
  TerrainRelief(int sectors, int rings, int disparities, int height_px);

  /// Sets what all sectors share, before the functions below. `sigma_px`: noise of disparities by ring.
  void begin(const TerrainCamera& camera, const Rings& rings, const float* sigma_px);
  /// Elevations of one sector's rings.
  void profile(int sector, const TerrainCamera& camera, const Rings& rings, const float* sigma_px,
               const PolarCell* cells);
  /// Rows of one sector, once all sectors have a profile.
  void fill(int sector, const TerrainCamera& camera, const Rings& rings);

  [[nodiscard]] Relief<Host> view() const { return {rows_.view()}; }
  [[nodiscard]] std::size_t held_bytes() const { return held_bytes_of(elevation_m_, noise_m_, rows_); }

 private:
  [[nodiscard]] float smoothed(int sector, int ring) const;

  int height_px_;
  Image<float> elevation_m_;  // (ring, sector)
  Image<float> noise_m_;      // (ring, 0): elevations up to here are 0
  Image<std::int16_t> rows_;  // (bin, sector)
};

}  // namespace stereogrid
