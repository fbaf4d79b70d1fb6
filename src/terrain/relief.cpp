// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stereogrid {
namespace {

constexpr float none{std::numeric_limits<float>::quiet_NaN()};
// Lengths in heights of the vehicle.
constexpr float half_width{1.4f};  ///< least half width of wide ground
constexpr float slope_base{1.4f};  ///< length over which a slope is measured
constexpr float ahead{0.8f};       ///< length over which ground continues
constexpr float continued{1.7f};   ///< length over which the slope of the last ground is extended
constexpr int reach_max{24};       ///< sectors
constexpr float noise_min_m{0.06f};
constexpr float noise_sigmas{2};

}  // namespace

TerrainRelief::TerrainRelief(int sectors, int rings, int disparities, int height_px)
    : height_px_{height_px},
      elevation_m_{rings, sectors},
      ground_before_{sectors + 1, rings},
      level_before_{sectors + 1, rings},
      ground_m_{rings, sectors},
      noise_m_{rings, 1},
      rows_{disparities * relief_bins_per_px, sectors} {}

void TerrainRelief::begin(const TerrainCamera& camera, const TerrainLimits& limits, const Rings& rings,
                          const float* sigma_px, int judged_rings) {
  limits_ = limits;
  judged_rings_ = judged_rings;
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float sigma_m{camera.elevation_sigma(camera.height_m, rings.middle_m(ring), sigma_px[ring])};
    noise_m_(ring, 0) = std::max(std::min(noise_min_m, limits.step_m / 2), noise_sigmas * sigma_m);
  }
}

// Pixels of a rising surface are noisier than those of a level one: its upper bound counts.
void TerrainRelief::profile(int sector, const TerrainCamera& camera, const Rings& rings, const float* sigma_px,
                            const PolarCell* cells) {
  for (int ring{0}; ring < rings.count(); ++ring) {
    const PolarCell& cell{cells[ring]};
    elevation_m_(ring, sector) = none;
    if (!cell.is_ground() || !cell.is_firm) continue;
    const float x{rings.middle_m(ring)};
    const float noise_m{camera.height_sigma(camera.height_m - cell.elevation_m, cell.slope, x, sigma_px[ring])};
    const float level_noise_m{camera.elevation_sigma(camera.height_m, x, sigma_px[ring])};
    elevation_m_(ring, sector) = cell.elevation_m + noise_sigmas * std::max(noise_m - level_noise_m, 0.0f);
  }
}

void TerrainRelief::count_level(int rings) {
  for (int ring{0}; ring < rings; ++ring) {
    std::int16_t ground{0};
    std::int16_t level{0};
    for (int sector{0}; sector < elevation_m_.height(); ++sector) {
      const float z{elevation_m_(ring, sector)};
      ground = static_cast<std::int16_t>(ground + (std::isnan(z) ? 0 : 1));
      level = static_cast<std::int16_t>(level + (std::abs(z) < noise_m_(ring, 0) ? 1 : 0));
      ground_before_(sector + 1, ring) = ground;
      level_before_(sector + 1, ring) = level;
    }
  }
}

// Median elevation of the sectors around, if most of them have ground that the vehicle can reach from it.
float TerrainRelief::wide_ground(int sector, int ring, int reach, float rise_per_sector) const {
  const int first{std::max(sector - reach, 0)};
  const int last{std::min(sector + reach, elevation_m_.height() - 1)};
  const auto is_most = [&](int sectors) { return 2 * sectors > last + 1 - first; };
  if (!is_most(ground_before_(last + 1, ring) - ground_before_(first, ring))) return none;
  if (is_most(level_before_(last + 1, ring) - level_before_(first, ring))) return 0;  // the median is 0 but for noise
  std::array<float, 2 * reach_max + 1> around{};
  std::size_t count{0};
  for (int i{first}; i <= last; ++i) {
    const float z{elevation_m_(ring, i)};
    if (!std::isnan(z)) around[count++] = z;
  }
  const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count));
  int reached{0};
  for (int i{first}; i <= last; ++i) {
    const float most{noise_m_(ring, 0) + rise_per_sector * static_cast<float>(std::abs(i - sector))};
    reached += std::abs(elevation_m_(ring, i) - *middle) < most ? 1 : 0;  // false: none
  }
  return is_most(reached) ? *middle : none;
}

// Ground ahead of `ring`, along the slope of the last slope_base_m.
TerrainRelief::Line TerrainRelief::line_before(int sector, int ring, const Rings& rings) const {
  const float* const z{ground_m_.row(sector)};
  int last{ring - 1};
  while (last >= 0 && std::isnan(z[last])) --last;
  if (last < 0) return {};
  const float base_m{slope_base * limits_.height_m};
  const float x{rings.middle_m(last)};
  int first{last};
  while (first >= 0 && (std::isnan(z[first]) || x - rings.middle_m(first) < base_m)) --first;
  if (first < 0) return {x, z[last], z[last] / std::max(x, base_m)};  // from the footprint
  return {x, z[last], (z[last] - z[first]) / (x - rings.middle_m(first))};
}

float TerrainRelief::continued_to(int sector, int ring, const Rings& rings) const {
  const Line line{line_before(sector, ring, rings)};
  return line.z + line.slope * std::min(rings.middle_m(ring) - line.x, continued * limits_.height_m);
}

// Wide ground that continues the ground before it. Rings in front of an obstacle, which the matcher's smear raises, are
// excluded.
void TerrainRelief::connect(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells) {
  for (int ring{0}; ring < rings.count(); ++ring) {
    float& ground{ground_m_(ring, sector)};
    ground = none;
    if (ring + 1 < rings.count() && cells[ring + 1].kind == TerrainClass::obstacle) continue;
    const float x{rings.middle_m(ring)};
    const float sector_m{sector_px * x / camera.focal_px};
    const int reach{std::clamp(static_cast<int>(half_width * limits_.height_m / sector_m), 2, reach_max)};
    const float z{wide_ground(sector, ring, reach, limits_.slope * sector_m)};
    const float expected{continued_to(sector, ring, rings)};
    if (std::abs(z - expected) < std::max(limits_.step_m, 2 * noise_m_(ring, 0))) ground = z;
  }
}

// The foot of a wall resembles the beginning of a slope: three quarters of the rings ahead must be ground.
void TerrainRelief::drop_feet(int sector, const Rings& rings) {
  float* const ground{ground_m_.row(sector)};
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float end_m{rings.middle_m(ring) + ahead * limits_.height_m};
    int rings_ahead{0};
    int ground_ahead{0};
    for (int i{ring + 1}; i < rings.count() && rings.middle_m(i) <= end_m; ++i) {
      ++rings_ahead;
      ground_ahead += std::isnan(ground[i]) ? 0 : 1;
    }
    if (4 * ground_ahead < 3 * rings_ahead) ground[ring] = none;
  }
}

// Elevations grow from 0 at the noise to their full value at twice the noise. Extended ground has twice the noise.
float TerrainRelief::elevation(int sector, int ring, const Rings& rings) const {
  const float known{ground_m_(ring, sector)};
  const float z{std::isnan(known) ? continued_to(sector, ring, rings) : known};
  const float noise{(std::isnan(known) ? 2 : 1) * noise_m_(ring, 0)};
  return std::clamp(2 * (z - std::clamp(z, -noise, noise)), std::min(z, 0.0f), std::max(z, 0.0f));
}

void TerrainRelief::fill(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells) {
  connect(sector, camera, rings, cells);
  drop_feet(sector, rings);
  std::int16_t* const rows{rows_.row(sector)};
  const auto most = static_cast<float>(height_px_);
  int ring{-1};
  float x_from{0};
  float z_from{0};
  float x_to{0};
  float z_to{0};
  for (int bin{rows_.width() - 1}; bin >= 0; --bin) {
    const float x{camera.range((static_cast<float>(bin) + 0.5f) / relief_bins_per_px)};
    while (x > x_to && ring + 1 < rings.count()) {
      ++ring;
      x_from = x_to;
      z_from = z_to;
      x_to = rings.middle_m(ring);
      z_to = elevation(sector, ring, rings);
    }
    const float z{x > x_to ? z_to : z_from + (z_to - z_from) * (x - x_from) / (x_to - x_from)};
    rows[bin] = static_cast<std::int16_t>(std::clamp(std::round(z / (x * camera.tangent_per_v)), -most, most));
  }
}

}  // namespace stereogrid
