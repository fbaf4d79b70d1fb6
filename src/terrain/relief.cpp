// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace stereogrid {
namespace {

constexpr float continued_m{3};  ///< behind the last ground its slope continues
constexpr float least_m{0.06f};
constexpr float least_sigmas{2};

}  // namespace

TerrainRelief::TerrainRelief(int sectors, int rings, int disparities, int height_px)
    : height_px_{height_px},
      elevation_m_{rings, sectors},
      noise_m_{rings, 1},
      rows_{disparities * relief_bins_per_px, sectors} {}

void TerrainRelief::begin(const TerrainCamera& camera, const Rings& rings, const float* sigma_px) {
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float sigma_m{camera.elevation_sigma(camera.height_m, rings.middle_m(ring), sigma_px[ring])};
    noise_m_(ring, 0) = std::max(least_m, least_sigmas * sigma_m);
  }
}

void TerrainRelief::profile(int sector, const TerrainCamera& camera, const Rings& rings, const float* sigma_px,
                            const PolarCell* cells) {
  static const float k{std::getenv("RK") ? (float)atof(std::getenv("RK")) : 2.f};
  float x{0};
  float z{0};
  float slope{0};
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float middle{rings.middle_m(ring)};
    if (cells[ring].is_ground()) {
      x = middle;
      z = cells[ring].elevation_m;
      slope = cells[ring].slope;
    }
    const float ground_m{z + slope * std::min(middle - x, continued_m)};
    const float noise_m{camera.height_sigma(camera.height_m - ground_m, slope, middle, sigma_px[ring])};
    const float level_noise_m{camera.elevation_sigma(camera.height_m, middle, sigma_px[ring])};
    elevation_m_(ring, sector) = ground_m + k * std::max(noise_m - level_noise_m, 0.0f);
  }
}

// Median of five sectors, less the noise.
float TerrainRelief::smoothed(int sector, int ring) const {
  std::array<float, 5> around{};
  for (int i{0}; i < 5; ++i) {
    around[static_cast<std::size_t>(i)] = elevation_m_(ring, std::clamp(sector + i - 2, 0, elevation_m_.height() - 1));
  }
  std::ranges::nth_element(around, around.begin() + 2);
  const float noise{noise_m_(ring, 0)};
  const float z{around[2]};
  static const int mode{std::getenv("RM") ? atoi(std::getenv("RM")) : 1};
  if (mode == 0) return z - std::clamp(z, -noise, noise);
  // from 0 at the noise to all of it at twice the noise
  return std::clamp(2 * (z - std::clamp(z, -noise, noise)), std::min(z, 0.0f), std::max(z, 0.0f));
}

void TerrainRelief::fill(int sector, const TerrainCamera& camera, const Rings& rings) {
  std::int16_t* const rows{rows_.row(sector)};
  std::fill_n(rows, rows_.width(), std::int16_t{0});
  if (rings.count() == 0) return;
  const auto most = static_cast<float>(height_px_);
  int ring{0};
  float x_from{0};
  float z_from{0};
  float x_to{rings.middle_m(0)};
  float z_to{smoothed(sector, 0)};
  for (int bin{rows_.width() - 1}; bin >= 0; --bin) {
    const float disparity{(static_cast<float>(bin) + 0.5f) / relief_bins_per_px};
    const float x{camera.range(disparity)};
    while (x > x_to && ring < rings.count()) {
      x_from = x_to;
      z_from = z_to;
      ++ring;
      if (ring == rings.count()) break;
      x_to = rings.middle_m(ring);
      z_to = smoothed(sector, ring);
    }
    const float share{std::min((x - x_from) / (x_to - x_from), 1.0f)};
    const float z{ring == rings.count() ? z_from : z_from + share * (z_to - z_from)};
    const float row{std::round(z / (x * camera.tangent_per_v))};
    rows[bin] = static_cast<std::int16_t>(std::clamp(row, -most, most));
  }
}

}  // namespace stereogrid
