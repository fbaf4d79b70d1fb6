// SPDX-License-Identifier: Apache-2.0
#include "terrain/rings.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid {

Rings::Rings(float cell_m, float farthest_m, int disparities)
    : cell_m_{cell_m},
      farthest_m_{farthest_m},
      borders_m_(static_cast<std::size_t>(std::ceil(farthest_m / cell_m)) + 2),
      ring_at_(static_cast<std::size_t>((static_cast<float>(disparities) + 1) * places_per_px) + 1) {}

void Rings::place(const TerrainCamera& camera, float nearest_m) {
  std::ranges::fill(ring_at_, static_cast<std::int16_t>(no_ring));
  count_ = 0;
  const float focal_baseline{camera.focal_baseline_pxm * places_per_px};
  const float first{std::min(focal_baseline / std::max(nearest_m, cell_m_), static_cast<float>(places()))};
  int place{static_cast<int>(first)};
  float x{focal_baseline / static_cast<float>(std::max(place, 1))};
  while (count_ < capacity() && x < farthest_m_) {
    const float length{
        std::max({cell_m_, 2 * camera.range_sigma(x, block_sigma_px), 2 * camera.row_length(camera.height_m, x)})};
    const int next{std::min(place - 1, static_cast<int>(focal_baseline / (x + length)))};
    if (next < 1) break;
    std::fill(ring_at_.begin() + next, ring_at_.begin() + place, static_cast<std::int16_t>(count_));
    borders_m_[static_cast<std::size_t>(count_)] = x;
    x = focal_baseline / static_cast<float>(next);
    borders_m_[static_cast<std::size_t>(++count_)] = x;
    place = next;
  }
}

}  // namespace stereogrid
