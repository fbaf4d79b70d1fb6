// SPDX-License-Identifier: Apache-2.0
#include "terrain/relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stereogrid {
namespace {

constexpr float no_ground_m{std::numeric_limits<float>::quiet_NaN()};
// Lengths in heights of the vehicle.
constexpr float half_width{1.4f};  ///< least half width of wide ground
constexpr float slope_base{1.4f};  ///< length over which a slope is measured
constexpr float continued{1.7f};   ///< length over which the slope of the last ground is extended
constexpr int reach_max{24};       ///< sectors
constexpr float noise_min_m{0.06f};
constexpr float noise_sigmas{2};

/// Ground that continues from the rings before a ring, along the slope of the last slope_base m. Rings in ascending
/// order; `ground_m`: NaN: none.
class GroundLine {
 public:
  GroundLine(const float* ground_m, const Rings& rings, const FirstGround& prior, float vehicle_height_m)
      : z_{ground_m},
        rings_{rings},
        prior_{prior},
        vehicle_height_m_{vehicle_height_m},
        base_m_{slope_base * vehicle_height_m} {}

  [[nodiscard]] float elevation_at(int ring) {
    for (; seen_ < ring; ++seen_) {
      if (!std::isnan(z_[seen_])) last_ = seen_;
    }
    if (last_ < 0) return prior_.elevation(rings_.middle_m(ring));
    const float x{rings_.middle_m(last_)};
    for (; searched_ <= last_ && x - rings_.middle_m(searched_) >= base_m_; ++searched_) {
      if (!std::isnan(z_[searched_])) first_ = searched_;
    }
    const float slope{first_ < 0 ? z_[last_] / std::max(x, base_m_)  // from the footprint
                                 : (z_[last_] - z_[first_]) / (x - rings_.middle_m(first_))};
    return z_[last_] + slope * std::min(rings_.middle_m(ring) - x, continued * vehicle_height_m_);
  }

 private:
  const float* z_;
  const Rings& rings_;
  const FirstGround& prior_;
  float vehicle_height_m_;
  float base_m_;
  int last_{-1};     ///< last ring with ground
  int first_{-1};    ///< last ring with ground by base_m_ before it
  int seen_{0};      ///< rings that `last_` is of
  int searched_{0};  ///< rings that `first_` is of
};

}  // namespace

TerrainRelief::TerrainRelief(int sectors, int rings, int disparities, int height_px)
    : height_px_{height_px},
      elevation_m_{rings, sectors},
      ground_before_{sectors + 1, rings},
      level_before_{sectors + 1, rings},
      ground_m_{rings, sectors},
      noise_m_{rings, 1},
      border_m_{rings + 1, sectors},
      bins_(static_cast<std::size_t>(disparities * relief_bins_per_px)),
      rows_{disparities * relief_bins_per_px, sectors} {}

void TerrainRelief::begin(const TerrainCamera& camera, const TerrainLimits& limits, const Rings& rings,
                          const float* sigma_px, const FirstGround& prior) {
  limits_ = limits;
  prior_ = prior;
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float sigma_m{camera.elevation_sigma(camera.height_m, rings.middle_m(ring), sigma_px[ring])};
    noise_m_(ring, 0) = std::max(std::min(noise_min_m, limits.step_m / 2), noise_sigmas * sigma_m);
  }
  place_bins(camera, rings);
}

// The middles of two rings around each bin, which all sectors have in common; the footprint is before the first.
void TerrainRelief::place_bins(const TerrainCamera& camera, const Rings& rings) {
  const auto middle_m = [&](int border) { return border == 0 ? 0.0f : rings.middle_m(border - 1); };
  int next{0};
  for (int bin{rows_.width() - 1}; bin >= 0; --bin) {
    const float x{camera.range((static_cast<float>(bin) + 0.5f) / relief_bins_per_px)};
    while (x > middle_m(next) && next < rings.count()) ++next;
    const bool is_beyond{x > middle_m(next)};
    const int from{is_beyond ? next : next - 1};
    bins_[static_cast<std::size_t>(bin)] = {from, next, is_beyond ? 0 : x - middle_m(from),
                                            is_beyond ? 1 : middle_m(next) - middle_m(from), x * camera.tangent_per_v};
  }
}

// Pixels of a rising surface are noisier than those of a level one: its upper bound counts.
void TerrainRelief::profile(int sector, const TerrainCamera& camera, const Rings& rings, const float* sigma_px,
                            const PolarCell* cells) {
  for (int ring{0}; ring < rings.count(); ++ring) {
    const PolarCell& cell{cells[ring]};
    elevation_m_(ring, sector) = no_ground_m;
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
  if (!is_most(ground_before_(last + 1, ring) - ground_before_(first, ring))) return no_ground_m;
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
  return is_most(reached) ? *middle : no_ground_m;
}

// Wide ground that continues the ground before it. Rings in front of an obstacle, which the matcher's smear raises, are
// excluded.
void TerrainRelief::connect(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells) {
  GroundLine line{ground_m_.row(sector), rings, prior_, limits_.height_m};
  for (int ring{0}; ring < rings.count(); ++ring) {
    float& ground{ground_m_(ring, sector)};
    ground = no_ground_m;
    if (ring + 1 < rings.count() && cells[ring + 1].kind == TerrainClass::obstacle) continue;
    const float x{rings.middle_m(ring)};
    const float sector_m{sector_px * x / camera.focal_px};
    const int reach{std::clamp(static_cast<int>(half_width * limits_.height_m / sector_m), 2, reach_max)};
    const float z{wide_ground(sector, ring, reach, limits_.slope * sector_m)};
    const float expected{line.elevation_at(ring)};
    if (std::abs(z - expected) < std::max(limits_.step_m, 2 * noise_m_(ring, 0))) ground = z;
  }
}

// Elevations grow from 0 at the noise to their full value at twice the noise. Extended ground has twice the noise.
void TerrainRelief::set_borders(int sector, const Rings& rings) {
  float* const border{border_m_.row(sector)};
  border[0] = 0;
  GroundLine line{ground_m_.row(sector), rings, prior_, limits_.height_m};
  for (int ring{0}; ring < rings.count(); ++ring) {
    const float known{ground_m_(ring, sector)};
    const float z{std::isnan(known) ? line.elevation_at(ring) : known};
    const float noise{(std::isnan(known) ? 2 : 1) * noise_m_(ring, 0)};
    border[ring + 1] = std::clamp(2 * (z - std::clamp(z, -noise, noise)), std::min(z, 0.0f), std::max(z, 0.0f));
  }
}

void TerrainRelief::fill(int sector, const TerrainCamera& camera, const Rings& rings, const PolarCell* cells) {
  connect(sector, camera, rings, cells);
  set_borders(sector, rings);
  const float* const border{border_m_.row(sector)};
  std::int16_t* const rows{rows_.row(sector)};
  if (std::all_of(border, border + rings.count() + 1, [](float z) { return z == 0; })) {
    std::fill_n(rows, rows_.width(), std::int16_t{0});
    return;
  }
  const auto most = static_cast<float>(height_px_);
  for (int bin{0}; bin < rows_.width(); ++bin) {
    const Bin& at{bins_[static_cast<std::size_t>(bin)]};
    const float z{border[at.from] + (border[at.to] - border[at.from]) * at.ahead_m / at.length_m};
    const float raised{std::clamp(z / at.row_m, -most, most)};
    const int whole{static_cast<int>(raised)};
    const float part{raised - static_cast<float>(whole)};
    rows[bin] = static_cast<std::int16_t>(whole + (part >= 0.5f ? 1 : 0) - (part <= -0.5f ? 1 : 0));
  }
}

}  // namespace stereogrid
