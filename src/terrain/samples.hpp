// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/relief.hpp"
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

/// Upper median of the disparities > 0 in columns `column` … column + sector_px − 1, at least three, of each row; 0:
/// fewer. A pixel has an obstacle's or a road disparity. Columns behind the image have none.
void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians);

/// The same in plain loops: the definition.
namespace plain {
void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians);
}

/// One sector of the samples. Rows are rows of the image.
struct SectorRows {
  const float* disparity;     ///< median of the sector's pixels in a row, px; 0: none, as in line_rows beside the image
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
  /// Sets the data of all sectors, before the functions below.
  void begin(const TerrainCamera& camera, const TerrainLimits& limits);
  /// Medians of sectors begin … end − 1, over pixels with an obstacle's or a road disparity.
  void read(int begin, int end, View<const float> obstacle, View<const float> road);
  /// Places of one sector's samples, once it and the next sector have been read.
  void place(int sector, const Rings& rings);
  /// Standard deviation of disparities by ring, once all sectors are placed, px (docs/terrain.md).
  void measure_noise(int rings, std::vector<float>& sigma_px) const;

  [[nodiscard]] const SectorRows& rows(int sector) const { return rows_[static_cast<std::size_t>(sector)]; }
  [[nodiscard]] std::size_t memory_bytes() const {
    return memory_bytes_of(disparity_, x_, z_, next_, first_, spread_, spread_count_, rows_);
  }

 private:
  [[nodiscard]] SectorRows rows_of(int sector) const;

  TerrainCamera camera_{Rig{}, Ground{}};
  TerrainLimits limits_{};
  int height_px_;
  int first_row_{0};
  Image<float> disparity_;  // (sector, row + line_rows)
  Image<float> x_;
  Image<float> z_;
  Image<std::int16_t> next_;
  Image<std::int16_t> first_;  // (sector, ring)
  Image<float> spread_;        // (sector, ring): sum of differences to the next sector
  Image<float> spread_count_;
  std::vector<SectorRows> rows_;  // by sector, of the frame
};

}  // namespace stereogrid
