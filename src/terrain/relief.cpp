// SPDX-License-Identifier: Apache-2.0
#include "terrain/relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace stereogrid {

TerrainRelief::TerrainRelief(int sectors, int rings, int disparities, int height_px)
    : elevation_m_{rings, sectors},
      ground_before_{sectors + 1, rings},
      level_before_{sectors + 1, rings},
      ground_m_{rings, sectors},
      noise_m_(static_cast<std::size_t>(rings)),
      border_m_{rings + 1, sectors},
      bins_(static_cast<std::size_t>(disparities * relief_bins_per_px)),
      rows_{disparities * relief_bins_per_px, sectors} {
  model_.height_px = height_px;
}

// All sectors have noise and bins in common.
void TerrainRelief::begin(const TerrainCamera& camera, const TerrainLimits& limits, const RingTable& rings,
                          const float* sigma_px, const FirstGround& prior) {
  model_ = {camera, limits, prior, rings, sigma_px, noise_m_.data(), model_.height_px};
  for (int ring{0}; ring < rings.count(); ++ring) noise_m_[static_cast<std::size_t>(ring)] = model_.level_m(ring);
  int before{0};
  for (std::size_t bin{bins_.size()}; bin-- > 0; before = bins_[bin].to)
    bins_[bin] = model_.bin_at(static_cast<int>(bin), before);
}

void TerrainRelief::profile(int sector, const PolarCell* cells) {
  for (int ring{0}; ring < model_.rings.count(); ++ring)
    elevation_m_(ring, sector) = model_.elevation(cells[ring], ring);
}

void TerrainRelief::count_level() {
  for (int ring{0}; ring < model_.rings.count(); ++ring) {
    std::int16_t ground{0};
    std::int16_t level{0};
    for (int sector{0}; sector < elevation_m_.height(); ++sector) {
      const float z{elevation_m_(ring, sector)};
      ground = static_cast<std::int16_t>(ground + (std::isnan(z) ? 0 : 1));
      level = static_cast<std::int16_t>(level + (std::abs(z) < model_.noise_m[ring] ? 1 : 0));
      ground_before_(sector + 1, ring) = ground;
      level_before_(sector + 1, ring) = level;
    }
  }
}

// Median elevation of the sectors around, if most of them have ground that the vehicle can reach from it.
float TerrainRelief::wide_ground(int sector, int ring) const {
  const int reach{model_.reach(ring)};
  const int first{std::max(sector - reach, 0)};
  const int last{std::min(sector + reach, elevation_m_.height() - 1)};
  const auto is_most = [&](int sectors) { return ReliefModel::is_most(sectors, last + 1 - first); };
  if (!is_most(ground_before_(last + 1, ring) - ground_before_(first, ring))) return ReliefModel::none_m;
  if (is_most(level_before_(last + 1, ring) - level_before_(first, ring))) return 0;  // the median is 0 but for noise
  std::array<float, 2 * ReliefModel::reach_max + 1> around{};
  std::size_t count{0};
  for (int i{first}; i <= last; ++i) {
    const float z{elevation_m_(ring, i)};
    if (!std::isnan(z)) around[count++] = z;
  }
  const auto middle = around.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(around.begin(), middle, around.begin() + static_cast<std::ptrdiff_t>(count));
  int reached{0};
  for (int i{first}; i <= last; ++i)
    reached += model_.is_reached(elevation_m_(ring, i), *middle, ring, std::abs(i - sector)) ? 1 : 0;  // false: none
  return is_most(reached) ? *middle : ReliefModel::none_m;
}

void TerrainRelief::fill(int sector, const PolarCell* cells) {
  const int rings{model_.rings.count()};
  float* const ground{ground_m_.row(sector)};
  for (int ring{0}; ring < rings; ++ring)
    ground[ring] = model_.is_before_obstacle(ring, cells) ? ReliefModel::none_m : wide_ground(sector, ring);
  model_.connect(ground);
  float* const border{border_m_.row(sector)};
  model_.set_borders(ground, border);
  std::int16_t* const rows{rows_.row(sector)};
  if (std::all_of(border, border + rings + 1, [](float z) { return z == 0; })) {
    std::fill_n(rows, rows_.width(), std::int16_t{0});
    return;
  }
  for (int bin{0}; bin < rows_.width(); ++bin) rows[bin] = model_.rows(bins_[static_cast<std::size_t>(bin)], border);
}

}  // namespace stereogrid
