// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include "terrain/walk.hpp"

namespace stereogrid {
namespace {

constexpr int neighbour_rings{3};  ///< edges of neighbours are the same one within so many rings

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

// Ring at which two thirds of up to six neighbours end; no_ring: they do not agree. Neighbours that have lost the
// ground nearer do not count.
int common_end(View<const SectorWalk> walks, int sector) {
  constexpr int reach{3};
  std::array<int, 2 * reach> ends{};
  ends.fill(std::numeric_limits<int>::max());
  std::size_t count{0};
  const int first{std::max(sector - reach, 0)};
  const int last{std::min(sector + reach, walks.width - 1)};
  for (int beside{first}; beside <= last; ++beside) {
    if (beside != sector && walks(beside, 0).end != no_ring) ends[count++] = walks(beside, 0).end;
  }
  if (count < 2) return no_ring;
  std::ranges::sort(ends);
  const int middle{ends[count / 2]};
  int passing{0};
  for (int beside{first}; beside <= last; ++beside) {
    const SectorWalk& walk{walks(beside, 0)};
    if (beside != sector && walk.end == no_ring && walk.lost > middle) ++passing;
  }
  return confirming(walks, sector, reach, &SectorWalk::end, middle) >= 2 * std::max(passing, 1) ? middle : no_ring;
}

}  // namespace

void compare_walks(int sector, View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  walk.common_end = common_end(walks, sector);
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
  if (confirming(walks, sector, 3, &SectorWalk::end, walk.end) >= walk.end_confirmations) {
    const TerrainClass kind{walk.end_kind == GapKind::drop ? TerrainClass::drop : TerrainClass::hidden};
    std::fill(cells + walk.end, cells + walk.end_seen + 1, PolarCell{.kind = kind});
    return;
  }
  for (int ring{walk.end}; ring < rings; ++ring) {
    if (cells[ring].kind == TerrainClass::hidden) cells[ring].kind = TerrainClass::unknown;
  }
}

namespace {

// One step of spread_hidden: from the sector before, which is `from`.
void spread_to(const PolarCell* from, int rings, PolarCell* cells) {
  for (int ring{0}; ring < rings; ++ring) {
    const bool is_behind_edge{from[ring].kind == TerrainClass::hidden || from[ring].kind == TerrainClass::drop};
    if (is_behind_edge && cells[ring].kind == TerrainClass::unknown) cells[ring].kind = TerrainClass::hidden;
  }
}

}  // namespace

void spread_hidden(int rings, View<PolarCell> cells) {
  constexpr int spread_sectors{8};
  for (int step{0}; step < spread_sectors; ++step) {
    for (int sector{cells.height - 1}; sector > 0; --sector) spread_to(cells.row(sector - 1), rings, cells.row(sector));
    for (int sector{0}; sector + 1 < cells.height; ++sector) spread_to(cells.row(sector + 1), rings, cells.row(sector));
  }
}

}  // namespace stereogrid
