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

// Neighbours, up to `reach` sectors to both sides, with an edge near `ring`.
int confirming(View<const SectorWalk> walks, int sector, int reach, int ring) {
  int count{0};
  for (int offset{-reach}; offset <= reach; ++offset) {
    const int beside{sector + offset};
    if (offset == 0 || beside < 0 || beside >= walks.width) continue;
    const int end{walks(beside, 0).end};
    if (end != no_ring && std::abs(end - ring) <= neighbour_rings) ++count;
  }
  return count;
}

// Ring at which most of six neighbours end; no_ring: they do not agree.
int common_end(View<const SectorWalk> walks, int sector) {
  std::array<int, 6> ends{};
  ends.fill(std::numeric_limits<int>::max());
  std::size_t count{0};
  for (const int offset : {-3, -2, -1, 1, 2, 3}) {
    const int beside{sector + offset};
    if (beside < 0 || beside >= walks.width || walks(beside, 0).end == no_ring) continue;
    ends[count++] = walks(beside, 0).end;
  }
  if (count < 4) return no_ring;
  std::ranges::sort(ends);
  const int middle{ends[count / 2]};
  return confirming(walks, sector, 3, middle) >= 4 ? middle : no_ring;
}

}  // namespace

void settle_sector(int sector, View<const SectorWalk> walks, int rings, PolarCell* cells) {
  const SectorWalk& walk{walks(sector, 0)};
  const bool is_confirmed{walk.end != no_ring && confirming(walks, sector, 2, walk.end) >= 2};
  const auto mark = [&](int first, int last, TerrainClass kind) {
    for (int ring{first}; ring <= last; ++ring) cells[ring] = {PolarCell{}.elevation_m, 0, kind};
  };
  if (is_confirmed) {
    const bool is_drop{walk.end_kind == GapKind::drop};
    return mark(walk.end, walk.end_seen, is_drop ? TerrainClass::drop : TerrainClass::hidden);
  }
  const int common{common_end(walks, sector)};
  if (common != no_ring) return mark(std::min(common + 1, rings), rings - 1, TerrainClass::hidden);
  if (walk.end == no_ring) return;
  for (int ring{walk.end}; ring < rings; ++ring) {
    if (cells[ring].kind == TerrainClass::hidden) cells[ring].kind = TerrainClass::unknown;
  }
}

}  // namespace stereogrid
