// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>

#include "terrain/walk.hpp"

namespace stereogrid {
namespace {

constexpr int neighbour_rings{3};  ///< distance within which edges of neighbours are the same

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

// Nearest sector to one side that ends at an edge near `ring`, or at any edge for no_ring, within `reach`; the
// sector itself: none.
int edge_beside(View<const SectorWalk> walks, int sector, int side, int ring) {
  constexpr int reach{24};
  for (int offset{1}; offset <= reach; ++offset) {
    const int beside{sector + side * offset};
    if (beside < 0 || beside >= walks.width) break;
    const int end{walks(beside, 0).end};
    if (end != no_ring && (ring == no_ring || std::abs(end - ring) <= neighbour_rings)) return beside;
  }
  return sector;
}

// Ring of edges to both sides of a sector that passes between them, or between one and the image's border; no_ring:
// none, none is confirmed, or the passage is wide.
int narrow_passage(const WalkInput& input, View<const SectorWalk> walks, int sector) {
  constexpr float widest_passage{0.25f};  // relative to the vehicle's height
  constexpr float widest_at_border{0.5f};
  constexpr int edge_confirmations{3};
  int ring{no_ring};
  for (const int side : {-1, 1}) {
    const int beside{edge_beside(walks, sector, side, no_ring)};
    if (beside != sector && (ring == no_ring || walks(beside, 0).end < ring)) ring = walks(beside, 0).end;
  }
  const SectorWalk& walk{walks(sector, 0)};
  if (ring == no_ring || (walk.end != no_ring && walk.end <= ring + neighbour_rings)) return no_ring;
  const int left{edge_beside(walks, sector, -1, ring)};
  const int right{edge_beside(walks, sector, 1, ring)};
  const auto is_confirmed = [&](int edge) {
    return edge != sector && confirming(walks, edge, 3, &SectorWalk::end, ring) >= edge_confirmations;
  };
  if (!is_confirmed(left) && !is_confirmed(right)) return no_ring;
  const int first{left == sector ? 0 : left + 1};
  const int end{right == sector ? walks.width : right};
  const float width_m{static_cast<float>((end - first) * sector_px) * input.rings.middle_m(ring) /
                      input.camera.focal_px};
  const bool is_at_border{left == sector || right == sector};
  return width_m <= (is_at_border ? widest_at_border : widest_passage) * input.limits.height_m ? ring : no_ring;
}

}  // namespace

void compare_walks(const WalkInput& input, int sector, View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  walk.passage_end = narrow_passage(input, walks, sector);
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
