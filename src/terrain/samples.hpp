// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
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

/// Differences of a ring's samples to the next sector.
struct RingSpread {
  float sum;  ///< px
  float count;
};

/// One sector of the samples. Rows are rows of the image. The arrays lie where the code runs.
struct SectorRows {
  const float* disparity;  ///< median of the sector's pixels in a row, px; 0: none
  float* x;                ///< m; valid where there is a disparity
  float* z;                ///< m
  std::int16_t* next;      ///< next row, upwards, with a sample in the same ring
  std::int16_t* first;     ///< lowest row with a sample in a ring
  bool* upright;           ///< see is_upright(), by row; null: not computed in advance
  float tangent_at_row_0;  ///< tangent of the line of sight
  float tangent_per_v;
  int first_row;  ///< rows from here to end_row − 1 are used
  int end_row;

  [[nodiscard]] STEREOGRID_HD float tangent(float v) const { return tangent_at_row_0 + tangent_per_v * v; }
  /// Growth of the disparity per row on the line through the rows around v, px; NaN: too few have one.
  [[nodiscard]] STEREOGRID_HD float growth(int v) const {
    float n{0};
    float r{0};
    float rr{0};
    float d{0};
    float dr{0};
    const int last{Min(line_rows, end_row - 1 - v)};
    for (int k{Max(-line_rows, first_row - v)}; k <= last; ++k) {
      const float there{disparity[v + k]};
      if (!(there > 0)) continue;
      const auto row = static_cast<float>(k);
      n += 1;
      r += row;
      rr += row * row;
      d += there;
      dr += there * row;
    }
    return n <= line_rows ? std::numeric_limits<float>::quiet_NaN() : (n * dr - r * d) / (n * rr - r * r);
  }
  /// The foot of an object. `slope`: tangent of the steepest ground.
  [[nodiscard]] STEREOGRID_HD bool is_upright(int v, const TerrainCamera& camera, float slope) const {
    return camera.is_upright(growth(v), x[v] * (tangent(static_cast<float>(v)) + slope));
  }
};

/// Samples of a frame by sector, for CPU and GPU. The arrays lie where the code runs.
struct SampleTable {
  SampledGround ground;
  View<const float> medians;  ///< (row, sector), valid from ground.first_row on; see find_medians()
  View<float> x;              ///< see SectorRows
  View<float> z;
  View<std::int16_t> next;
  View<std::int16_t> first;  ///< (ring, sector)
  View<RingSpread> spread;   ///< likewise
  View<bool> upright{};      ///< see SectorRows; empty: not computed in advance

  /// Largest difference of neighbouring sectors on one surface, px.
  static constexpr float spread_max_px{2};
  /// σ of the mean difference of two medians: √(π/2)/√2.
  static constexpr float sigma_per_spread{0.886f};
  static constexpr float spread_samples_min{8};
  /// Largest noise over the median of four nearer rings: jumps of the surface are no noise.
  static constexpr float noise_growth_max{1.5f};
  static constexpr float noise_max_px{1};

  [[nodiscard]] STEREOGRID_HD int sectors() const { return medians.height; }
  [[nodiscard]] STEREOGRID_HD SectorRows rows_of(int sector) const {
    return {medians.row(sector),
            x.row(sector),
            z.row(sector),
            next.row(sector),
            first.row(sector),
            upright.row(sector),
            ground.tangent_at_row_0(sector),
            ground.camera.tangent_per_v,
            ground.first_row,
            medians.width};
  }
  /// Sets the place of a sample. `there`: its disparity.
  STEREOGRID_HD static void place(float there, int v, float focal_baseline_pxm, float height_m, const SectorRows& s) {
    s.x[v] = focal_baseline_pxm / (there < 1e-3f ? 1e-3f : there);
    s.z[v] = height_m - s.tangent(static_cast<float>(v)) * s.x[v];
  }
  [[nodiscard]] STEREOGRID_HD static int ring_of(float there, const RingTable& rings) {
    const auto places = static_cast<float>(rings.places());
    return there > 0 ? rings.at_place(static_cast<int>(Min(there * RingTable::places_per_px, places))) : no_ring;
  }
  /// Difference to the next sector, px; spread_max_px or NaN: not on one surface.
  [[nodiscard]] STEREOGRID_HD static float difference(float there, float beside, float roll_px) {
    return beside > 0 ? std::abs(beside - there - roll_px) : spread_max_px;
  }
  /// Difference of the ground's disparities in neighbouring sectors, px.
  [[nodiscard]] STEREOGRID_HD float roll_px() const {
    return ground.camera.tangent_per_u * sector_px * ground.camera.focal_baseline_pxm / ground.camera.height_m;
  }
  /// Spread of a ring in all sectors, once all are placed.
  [[nodiscard]] STEREOGRID_HD RingSpread spread_of(int ring) const {
    RingSpread sum{};
    for (int sector{0}; sector < sectors(); ++sector) {
      sum.sum += spread(ring, sector).sum;
      sum.count += spread(ring, sector).count;
    }
    return sum;
  }
  /// Standard deviation of a ring's disparities, after those of the nearer ones, px (docs/terrain.md).
  [[nodiscard]] STEREOGRID_HD static float noise_of(int ring, RingSpread of, const float* sigma_px) {
    float sigma{of.count >= spread_samples_min ? sigma_per_spread * of.sum / of.count : 0.0f};
    if (ring >= 4) {
      const float* const nearer{sigma_px + ring - 4};
      const float low{Max(Min(nearer[0], nearer[1]), Min(nearer[2], nearer[3]))};
      const float high{Min(Max(nearer[0], nearer[1]), Max(nearer[2], nearer[3]))};
      sigma = Min(sigma, noise_growth_max * 0.5f * (Min(low, high) + Max(low, high)));
      if (of.count < spread_samples_min) sigma = Min(low, high);
    }
    return Min(Max(sigma, block_sigma_px), noise_max_px);
  }
};

}  // namespace stereogrid
