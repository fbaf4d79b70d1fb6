// SPDX-License-Identifier: Apache-2.0
#include "terrain/walk.hpp"

#include <algorithm>
#include <utility>

#include "terrain/settle.hpp"
#include "terrain/walk_steps.hpp"

namespace stereogrid {

SectorWalks::SectorWalks(const Rig& level_rig, int rings, int window_rows)
    : window_rows_{static_cast<float>(window_rows)},
      medians_{level_rig.height_px, terrain_sectors(level_rig.width_px)},
      x_{level_rig.height_px, medians_.height()},
      z_{level_rig.height_px, medians_.height()},
      next_{level_rig.height_px, medians_.height()},
      first_{rings, medians_.height()},
      spread_{rings, medians_.height()},
      rows_(static_cast<std::size_t>(medians_.height())),
      sigma_px_(static_cast<std::size_t>(rings)),
      trenches_{level_rig.height_px, medians_.height(), window_rows},
      cells_{rings, medians_.height()},
      walks_{medians_.height(), 1},
      reached_{medians_.height(), 1} {}

SampleTable SectorWalks::samples() {
  return {frame_.ground, medians_.view(), x_.view(), z_.view(), next_.view(), first_.view(), spread_.view()};
}

void SectorWalks::place(const SampleTable& table, int sector) {
  const SectorRows s{table.rows_of(sector)};
  rows_[static_cast<std::size_t>(sector)] = s;
  const float focal_baseline_pxm{table.ground.camera.focal_baseline_pxm};  // members might change with each store
  const float height_m{table.ground.camera.height_m};
  for (int v{s.first_row}; v < s.end_row; ++v) SampleTable::place(s.disparity[v], v, focal_baseline_pxm, height_m, s);
  RingSpread* const spread{spread_.row(sector)};
  std::fill_n(s.first, frame_.rings.count(), static_cast<std::int16_t>(no_row));
  std::fill_n(spread, frame_.rings.count(), RingSpread{});
  const bool is_last{sector + 1 == table.sectors()};
  const float* const beside{medians_.row(is_last ? sector : sector + 1)};
  const float roll_px{table.roll_px()};
  for (int v{s.first_row}; v < s.end_row; ++v) {
    const float there{s.disparity[v]};
    const int ring{SampleTable::ring_of(there, frame_.rings)};
    if (ring == no_ring) continue;
    s.next[v] = s.first[ring];
    s.first[ring] = static_cast<std::int16_t>(v);
    const float difference{SampleTable::difference(there, beside[v], roll_px)};
    if (is_last || !(difference < SampleTable::spread_max_px)) continue;
    spread[ring].sum += difference;
    spread[ring].count += 1;
  }
}

WalkInput SectorWalks::input() const {
  return {frame_.ground.camera,
          frame_.ground.limits,
          frame_.rings,
          rows_.data(),
          walks_.width(),
          sigma_px_.data(),
          checked_rings_of(frame_.ground, frame_.rings, sigma_px_.data()),
          window_rows_,
          frame_.prior};
}

void SectorWalks::measure_noise(const SampleTable& table) {
  for (int ring{0}; ring < frame_.rings.count(); ++ring)
    sigma_px_[static_cast<std::size_t>(ring)] = SampleTable::noise_of(ring, table.spread_of(ring), sigma_px_.data());
}

void SectorWalks::walk(const WalkInput& input, int sector) {
  walk_sector(input, sector, std::as_const(trenches_).at(sector), cells_.view(), walks_(sector, 0));
}

// Ring by ring: all sectors step, then those that have lost the ground take over that of neighbours, in rounds until
// none changes.
void SectorWalks::spread_ground(const WalkInput& input) {
  const View<PolarCell> cells{cells_.view()};
  const View<SectorWalk> walks{walks_.view()};
  const auto for_all = [&](const auto& work) {
    for (int sector{0}; sector < walks.width; ++sector) work(sector, walks(sector, 0));
  };
  for_all([&](int sector, SectorWalk&) { confirm_block(sector, walks); });
  for_all([&](int sector, SectorWalk& walk) { drop_lone_obstacle(cells.row(sector), walk); });
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    for_all([&](int sector, SectorWalk& walk) { step_on(input, sector, ring, cells, walk); });
    for (bool is_changed{true}; is_changed;) {
      is_changed = false;
      for_all([&](int sector, SectorWalk&) { is_changed |= take_over(input, sector, ring, cells, walks); });
      if (is_changed) for_all([&](int sector, SectorWalk& walk) { settle_taken(sector, ring, cells, walk); });
    }
  }
  for_all([&](int sector, SectorWalk&) { settle_sector(sector, walks, input.rings.count(), cells.row(sector)); });
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    spread_hidden(ring, cells);
    fill_streaks(input, ring, walks, cells);
  }
  hide_unconnected(input, cells, reached_.view());
  for (int ring{0}; ring < input.rings.count(); ++ring) hide_ends(input, ring, cells);
}

void hide_unconnected(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached_sectors) {
  std::uint8_t* const reached{reached_sectors.row(0)};  // in the ring before
  std::fill_n(reached, cells.height, std::uint8_t{1});
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    const RingWays ways{input, ring};
    for (int begin{0}; begin < cells.height;) {
      const bool is_behind{is_behind_edge(cells(ring, begin))};
      int end{begin + 1};
      while (end < cells.height && is_behind_edge(cells(ring, end)) == is_behind) ++end;
      const int from{std::clamp(ways.first, begin, end)};
      const bool is_reached{!is_behind && std::count(reached + from, reached + end, 1) >= ways.narrowest};
      for (int sector{begin}; sector < end && !is_behind && !is_reached; ++sector)
        if (cells(ring, sector).is_ground()) cells(ring, sector) = PolarCell{.kind = TerrainClass::hidden};
      std::fill(reached + begin, reached + end, static_cast<std::uint8_t>(is_reached));
      begin = end;
    }
  }
}

}  // namespace stereogrid
