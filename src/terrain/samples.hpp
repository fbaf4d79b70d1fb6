// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "memory_bytes.hpp"
#include "stereogrid/image.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"

namespace stereogrid {

constexpr int no_row{-1};
/// Pixels of a sector's row that make a sample.
constexpr int samples_min{3};
/// Rows on both sides of the line through a sample's neighbours.
constexpr int line_rows{4};

/// Rows begin … end − 1 of an image.
struct ImageRows {
  int begin;
  int end;
};

/// Sectors of an image, of sector_px columns. Those behind the last whole sector belong to none.
constexpr int terrain_sectors(int width_px) {
  return std::max(1, width_px / sector_px);
}

/// Upper median of the disparities > 0 in columns `column` … column + sector_px − 1, at least three, of each row; 0:
/// fewer. A pixel has an obstacle's or a road disparity. Columns behind the image have none.
void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians);

/// The same in plain loops: the definition.
namespace plain {
void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians);
}

/// The same of the sectors begin … end − 1, in rows from `first_row` on. `medians`: (row, sector).
void find_medians(View<const float> obstacle, View<const float> road, int begin, int end, int first_row,
                  View<float> medians);

/// Ground of a frame that has samples.
struct SampledGround {
  SampledGround() = default;
  SampledGround(const TerrainCamera& level_camera, const TerrainLimits& vehicle_limits, int width_px, int height_px);

  /// Tangent of the line of sight in the middle of a sector.
  [[nodiscard]] STEREOGRID_HD float tangent_at_row_0(int sector) const {
    return camera.tangent((static_cast<float>(sector) + 0.5f) * sector_px - 0.5f, 0);
  }

  TerrainCamera camera{Rig{}, Ground{}};
  TerrainLimits limits{};
  /// The walk reaches nothing that is seen above it: rows above the line of sight along half the steepest slope.
  int first_row{0};
};

/// One sector of the samples. Rows are rows of the image.
struct SectorRows {
  const float* disparity;     ///< median of the sector's pixels in a row, px; 0: none
  const float* x;             ///< m; valid where there is a disparity
  const float* z;             ///< m
  const std::int16_t* next;   ///< next row, upwards, with a sample in the same ring
  const std::int16_t* first;  ///< lowest row with a sample in a ring
  float tangent_at_row_0;     ///< tangent of the line of sight
  float tangent_per_v;
  int first_row;  ///< rows from here to end_row − 1 are used
  int end_row;

  [[nodiscard]] float tangent(float v) const { return tangent_at_row_0 + tangent_per_v * v; }
  /// Growth of the disparity per row on the line through the rows around v, px; NaN: too few have one.
  [[nodiscard]] float growth(int v) const;
};

/// Median disparities of a frame by sector and row, and their places.
class TerrainSamples {
 public:
  TerrainSamples(int width_px, int height_px, int rings);

  [[nodiscard]] int sectors() const { return x_.height(); }
  /// Sets the data of all sectors, before the functions below. `medians`: (row, sector), valid from the ground's first
  /// row on, and while the samples are used; see find_medians().
  void begin(const SampledGround& ground, View<const float> medians);
  /// Places of one sector's samples.
  void place(int sector, const Rings& rings);
  /// Standard deviation of disparities by ring, once all sectors are placed, px (docs/terrain.md).
  void measure_noise(int rings, std::vector<float>& sigma_px) const;

  [[nodiscard]] const SectorRows& rows(int sector) const { return rows_[static_cast<std::size_t>(sector)]; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(x_, z_, next_, first_, spread_, spread_count_, rows_);
  }

 private:
  [[nodiscard]] SectorRows rows_of(int sector) const;

  SampledGround ground_;
  View<const float> medians_{};
  Image<float> x_;  // (row, sector)
  Image<float> z_;
  Image<std::int16_t> next_;
  Image<std::int16_t> first_;  // (ring, sector)
  Image<float> spread_;        // (ring, sector): sum of differences to the next sector
  Image<float> spread_count_;
  std::vector<SectorRows> rows_;  // by sector, of the frame
};

}  // namespace stereogrid
