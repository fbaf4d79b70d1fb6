// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/relief.hpp"
#include "memory_bytes.hpp"
#include "terrain/walk.hpp"

namespace stereogrid {

/// The ground of all sectors as a Relief. Ground must be wide and continue, which excludes the feet of obstacles.
/// Elevations within the noise are 0: level ground is the plane.
class TerrainRelief {
 public:
  TerrainRelief(int sectors, int rings, int disparities, int height_px);

  /// Sets the data of all sectors, before the functions below. `sigma_px`: noise of disparities by ring.
  void begin(const TerrainCamera& camera, const TerrainLimits& limits, const Rings& rings, const float* sigma_px,
             const FirstGround& prior);
  /// Elevations of one sector's rings.
  void profile(int sector, const TerrainCamera& camera, const Rings& rings, const float* sigma_px,
               const PolarCell* cells);
  /// Prepares fill(), once all sectors have a profile.
  void count_level(int rings);
  void fill(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells);

  [[nodiscard]] Relief<Host> view() const { return {rows_.view()}; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(elevation_m_, ground_before_, level_before_, ground_m_, noise_m_, border_m_, bins_, rows_);
  }

 private:
  /// Place of a bin between the middles of two rings. Border 0: the footprint, border k + 1: the middle of ring k.
  struct Bin {
    int from;
    int to;
    float ahead_m;   ///< distance from the border `from`
    float length_m;  ///< distance between both
    float row_m;     ///< height of a row of the image there
  };

  void place_bins(const TerrainCamera& camera, const Rings& rings);
  void connect(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells);
  [[nodiscard]] float wide_ground(int sector, int ring, int reach, float rise_per_sector) const;
  void set_borders(int sector, const Rings& rings);

  TerrainLimits limits_{};
  FirstGround prior_;
  int height_px_;
  Image<float> elevation_m_;           // (ring, sector); NaN: no firm ground
  Image<std::int16_t> ground_before_;  // (sector, ring): sectors before it with firm ground
  Image<std::int16_t> level_before_;   // (sector, ring): sectors before it with elevations within the noise
  Image<float> ground_m_;              // (ring, sector): wide ground; NaN: none
  Image<float> noise_m_;               // (ring, 0): elevations up to here are 0
  Image<float> border_m_;              // (border, sector): elevation
  std::vector<Bin> bins_;
  Image<std::int16_t> rows_;  // (bin, sector)
};

}  // namespace stereogrid
