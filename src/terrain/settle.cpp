// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "terrain/walk.hpp"

namespace stereogrid {
namespace {

constexpr int neighbour_rings{3};  ///< distance within which edges of neighbours are the same

bool is_behind_edge(const PolarCell& cell) {
  return cell.kind == TerrainClass::hidden || cell.kind == TerrainClass::drop;
}

// Neighbours, up to `reach` sectors to both sides, whose `what`, edge or obstacle, is near `ring`.
int confirming(View<const SectorWalk> walks, int sector, int reach, int SectorWalk::*what, int ring) {
  int count{0};
  for (int offset{-reach}; offset <= reach; ++offset) {
    const int beside{sector + offset};
    if (offset == 0 || beside < 0 || beside >= walks.width) continue;
    const int found{walks(beside, 0).*what};
    if (found != no_ring && std::abs(found - ring) <= neighbour_rings) ++count;
  }
  return count;
}

}  // namespace

bool is_end_confirmed(int sector, View<const SectorWalk> walks) {
  const SectorWalk& walk{walks(sector, 0)};
  return confirming(walks, sector, 3, &SectorWalk::end, walk.end) >= walk.end_confirmations;
}

void confirm_block(int sector, View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  walk.is_block_confirmed =
      confirming(walks, sector, 2, &SectorWalk::blocked, walk.blocked) >= walk.block_confirmations;
}

void settle_sector(int sector, View<const SectorWalk> walks, int rings, PolarCell* cells) {
  const SectorWalk& walk{walks(sector, 0)};
  if (walk.blocked != no_ring && !walk.is_block_confirmed &&
      confirming(walks, sector, 2, &SectorWalk::blocked, walk.blocked) < walk.block_confirmations) {
    cells[walk.blocked] = PolarCell{};
  }
  if (walk.end == no_ring) return;
  if (is_end_confirmed(sector, walks)) {
    const TerrainClass kind{walk.end_kind == GapKind::drop ? TerrainClass::drop : TerrainClass::hidden};
    std::fill(cells + walk.end, cells + walk.end_seen + 1, PolarCell{.kind = kind});
    return;
  }
  for (int ring{walk.end}; ring < rings; ++ring) {
    if (cells[ring].kind == TerrainClass::hidden) cells[ring].kind = TerrainClass::unknown;
  }
}

void spread_hidden(int rings, View<PolarCell> cells) {
  constexpr int spread_sectors{8};
  for (int ring{0}; ring < rings; ++ring) {
    const auto hide = [&](int begin, int end) {
      for (int sector{begin}; sector < end; ++sector) cells(ring, sector).kind = TerrainClass::hidden;
    };
    for (int begin{0}; begin < cells.height; ++begin) {
      int end{begin};
      while (end < cells.height && cells(ring, end).kind == TerrainClass::unknown) ++end;
      const bool is_edge_behind{end < cells.height && is_behind_edge(cells(ring, end))};
      const int right{is_edge_behind ? std::max(end - spread_sectors, begin) : end};
      if (begin > 0 && is_behind_edge(cells(ring, begin - 1))) hide(begin, std::min(begin + spread_sectors, right));
      hide(right, end);
      begin = end;
    }
  }
}

namespace {

// Sectors between `left` and `right`, `width_m` apart, if the ground of both is alike.
void fill_streak(const WalkInput& input, int ring, int left, int right, float width_m, View<PolarCell> cells) {
  const PolarCell& from{cells(ring, left)};
  const PolarCell& to{cells(ring, right)};
  const float alike_m{std::max(input.limits.step_m, input.limits.slope * width_m)};
  if (std::abs(to.elevation_m - from.elevation_m) > alike_m) return;
  for (int sector{left + 1}; sector < right; ++sector) {
    const float share{static_cast<float>(sector - left) / static_cast<float>(right - left)};
    cells(ring, sector) = {std::lerp(from.elevation_m, to.elevation_m, share), std::lerp(from.slope, to.slope, share),
                           TerrainClass::drivable, from.is_firm && to.is_firm};
  }
}

}  // namespace

void fill_streaks(const WalkInput& input, View<const SectorWalk> walks, View<PolarCell> cells) {
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    const float length_m{
        std::min(input.rings.end_m(ring) - input.rings.begin_m(ring), passage_width * input.limits.height_m)};
    const float sector_m{sector_px * input.rings.middle_m(ring) / input.camera.focal_px};
    const int widest{static_cast<int>(length_m / sector_m)};
    int ground{cells.height};  // last one
    for (int sector{0}; sector < cells.height; ++sector) {
      if (cells(ring, sector).is_ground()) {
        const int apart{sector - ground};
        if (apart > 1 && apart - 1 <= widest)
          fill_streak(input, ring, ground, sector, static_cast<float>(apart) * sector_m, cells);
        ground = sector;
      } else if (cells(ring, sector).kind != TerrainClass::unknown || walks(sector, 0).state.is_blocked) {
        ground = cells.height;
      }
    }
  }
}

void hide_unconnected(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached_sectors) {
  std::uint8_t* const reached{reached_sectors.row(0)};  // in the ring before
  std::fill_n(reached, cells.height, std::uint8_t{1});
  for (int ring{0}; ring < input.rings.count(); ++ring) {
    const float x{input.rings.middle_m(ring)};
    // the right camera sees none before
    const int first{std::min(static_cast<int>(input.camera.focal_baseline_pxm / x) / sector_px, cells.height)};
    const float width{input.limits.height_m * input.camera.focal_px / (sector_px * x)};
    const int narrowest{std::min(static_cast<int>(std::ceil(width)), cells.height - first)};
    for (int begin{0}; begin < cells.height;) {
      const bool is_behind{is_behind_edge(cells(ring, begin))};
      int end{begin + 1};
      while (end < cells.height && is_behind_edge(cells(ring, end)) == is_behind) ++end;
      const int from{std::clamp(first, begin, end)};
      const bool is_reached{!is_behind && std::count(reached + from, reached + end, 1) >= narrowest};
      for (int sector{begin}; sector < end && !is_behind && !is_reached; ++sector)
        if (cells(ring, sector).is_ground()) cells(ring, sector) = PolarCell{.kind = TerrainClass::hidden};
      std::fill(reached + begin, reached + end, static_cast<std::uint8_t>(is_reached));
      begin = end;
    }
  }
}

}  // namespace stereogrid
