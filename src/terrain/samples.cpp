// SPDX-License-Identifier: Apache-2.0
#include "terrain/samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "geometry/relief.hpp"

namespace stereogrid::plain {

void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians) {
  for (int v{rows.begin}; v < rows.end; ++v) {
    std::array<float, sector_px> found{};
    std::size_t count{0};
    for (int u{column}; u < std::min(column + sector_px, obstacle.width); ++u) {
      const float disparity{std::max(obstacle(u, v), road(u, v))};
      if (!(disparity > 0)) continue;
      std::size_t place{count++};
      for (; place > 0 && found[place - 1] > disparity; --place) found[place] = found[place - 1];
      found[place] = disparity;
    }
    *medians++ = count < samples_min ? 0.0f : found[count / 2];
  }
}

}  // namespace stereogrid::plain

namespace stereogrid {
namespace {

/// Rows that are read together.
constexpr int read_rows{16};

/// Largest difference of neighbouring sectors on one surface, px.
constexpr float spread_max_px{2};
/// σ of the mean difference of two medians: √(π/2)/√2.
constexpr float sigma_per_spread{0.886f};
constexpr float spread_samples_min{8};
constexpr float noise_growth_max{1.5f};  ///< over the median of four nearer rings: jumps of the surface are no noise
constexpr float noise_max_px{1};

}  // namespace

float SectorRows::growth(int v) const {
  float n{0};
  float r{0};
  float rr{0};
  float d{0};
  float dr{0};
  const int last{std::min(line_rows, end_row - 1 - v)};
  for (int k{std::max(-line_rows, first_row - v)}; k <= last; ++k) {
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

// Some rows of all sectors at a time: neighbours share cache lines.
void find_medians(View<const float> obstacle, View<const float> road, int begin, int end, int first_row,
                  View<float> medians) {
  for (int v{first_row}; v < medians.width;) {
    const int rows{medians.width - v < 2 * read_rows ? medians.width - v : read_rows};
    for (int sector{begin}; sector < end; ++sector) {
      find_medians(obstacle, road, sector * sector_px, {v, v + rows}, medians.row(sector) + v);
    }
    v += rows;
  }
}

SampledGround::SampledGround(const TerrainCamera& level_camera, const TerrainLimits& vehicle_limits, int width_px,
                             int height_px)
    : camera{level_camera}, limits{vehicle_limits} {
  const float middle{camera.tangent(static_cast<float>(terrain_sectors(width_px) * sector_px) / 2, 0)};
  const float row{(-limits.slope / 2 - middle) / camera.tangent_per_v};
  first_row = static_cast<int>(std::clamp(row, 0.0f, static_cast<float>(height_px)));
}

TerrainSamples::TerrainSamples(int width_px, int height_px, int rings)
    : x_{height_px, terrain_sectors(width_px)},
      z_{height_px, x_.height()},
      next_{height_px, x_.height()},
      first_{rings, x_.height()},
      spread_{rings, x_.height()},
      spread_count_{rings, x_.height()},
      rows_(static_cast<std::size_t>(x_.height())) {}

void TerrainSamples::begin(const SampledGround& ground, View<const float> medians) {
  ground_ = ground;
  medians_ = medians;
  for (int sector{0}; sector < sectors(); ++sector) rows_[static_cast<std::size_t>(sector)] = rows_of(sector);
}

void TerrainSamples::place(int sector, const Rings& rings) {
  const SectorRows s{rows(sector)};
  float* const x{x_.row(sector)};
  float* const z{z_.row(sector)};
  const float focal_baseline_pxm{ground_.camera.focal_baseline_pxm};  // members might change with each store
  const float height_m{ground_.camera.height_m};
  for (int v{s.first_row}; v < s.end_row; ++v) {
    const float there{s.disparity[v]};
    x[v] = focal_baseline_pxm / (there < 1e-3f ? 1e-3f : there);
    z[v] = height_m - s.tangent(static_cast<float>(v)) * x[v];
  }
  std::int16_t* const first{first_.row(sector)};
  std::int16_t* const next{next_.row(sector)};
  float* const spread{spread_.row(sector)};
  float* const spread_count{spread_count_.row(sector)};
  std::fill_n(first, first_.width(), static_cast<std::int16_t>(no_row));
  std::fill_n(spread, spread_.width(), 0.0f);
  std::fill_n(spread_count, spread_count_.width(), 0.0f);
  const bool is_last{sector + 1 == sectors()};
  const float* const beside{medians_.row(is_last ? sector : sector + 1)};
  const auto places = static_cast<float>(rings.places());
  const float roll_px{ground_.camera.tangent_per_u * sector_px * focal_baseline_pxm / height_m};
  for (int v{s.first_row}; v < s.end_row; ++v) {
    const float there{s.disparity[v]};
    const int ring{there > 0 ? rings.at_place(static_cast<int>(std::min(there * Rings::places_per_px, places)))
                             : no_ring};
    if (ring == no_ring) continue;
    next[v] = first[ring];
    first[ring] = static_cast<std::int16_t>(v);
    if (is_last) continue;
    const float difference{std::abs(beside[v] - there - roll_px)};
    if (!(beside[v] > 0) || !(difference < spread_max_px)) continue;
    spread[ring] += difference;
    spread_count[ring] += 1;
  }
}

void TerrainSamples::measure_noise(int rings, std::vector<float>& sigma_px) const {
  for (int ring{0}; ring < rings; ++ring) {
    float sum{0};
    float count{0};
    for (int sector{0}; sector < sectors(); ++sector) {
      sum += spread_(ring, sector);
      count += spread_count_(ring, sector);
    }
    const auto r = static_cast<std::size_t>(ring);
    float sigma{count >= spread_samples_min ? sigma_per_spread * sum / count : 0.0f};
    if (r >= 4) {
      std::array<float, 4> nearer{sigma_px[r - 1], sigma_px[r - 2], sigma_px[r - 3], sigma_px[r - 4]};
      std::ranges::sort(nearer);
      sigma = std::min(sigma, noise_growth_max * 0.5f * (nearer[1] + nearer[2]));
      if (count < spread_samples_min) sigma = nearer[1];
    }
    sigma_px[r] = std::clamp(sigma, block_sigma_px, noise_max_px);
  }
}

SectorRows TerrainSamples::rows_of(int sector) const {
  return {medians_.row(sector),
          x_.row(sector),
          z_.row(sector),
          next_.row(sector),
          first_.row(sector),
          ground_.tangent_at_row_0(sector),
          ground_.camera.tangent_per_v,
          ground_.first_row,
          medians_.width};
}
}  // namespace stereogrid
