// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "terrain/walk.hpp"

namespace stereogrid {

constexpr int neighbour_rings{3};  ///< distance within which edges of neighbours are the same

STEREOGRID_HD inline bool is_behind_edge(const PolarCell& cell) {
  return cell.kind == TerrainClass::hidden || cell.kind == TerrainClass::drop;
}

// Neighbours, up to `reach` sectors to both sides, whose `what`, edge or obstacle, is near `ring`.
STEREOGRID_HD inline int confirming(View<const SectorWalk> walks, int sector, int reach, int SectorWalk::*what,
                                    int ring) {
  int count{0};
  for (int offset{-reach}; offset <= reach; ++offset) {
    const int beside{sector + offset};
    if (offset == 0 || beside < 0 || beside >= walks.width) continue;
    const int found{walks(beside, 0).*what};
    if (found != no_ring && std::abs(found - ring) <= neighbour_rings) ++count;
  }
  return count;
}

/// Enough neighbours have their edges near that of the sector.
STEREOGRID_HD inline bool is_end_confirmed(int sector, View<const SectorWalk> walks) {
  const SectorWalk& walk{walks(sector, 0)};
  return confirming(walks, sector, 3, &SectorWalk::end, walk.end) >= walk.end_confirmations;
}

/// Compares the obstacle that ended a walk with those of its neighbours, once all sectors have been walked.
STEREOGRID_HD inline void confirm_block(int sector, View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  walk.is_block_confirmed =
      confirming(walks, sector, 2, &SectorWalk::blocked, walk.blocked) >= walk.block_confirmations;
}

/// Marks an obstacle from its foot on, or drops one that neighbours do not confirm: wrong matches resemble one in a
/// sector or two. Rays detect thin and tall objects.
STEREOGRID_HD inline void settle_block(bool is_confirmed, const SectorWalk& walk, PolarCell* cells) {
  if (walk.blocked == no_ring) return;
  if (!is_confirmed) cells[walk.blocked] = PolarCell{};
  for (int ring{walk.foot}; ring < walk.blocked && is_confirmed; ++ring) {
    if (cells[ring].is_ground()) cells[ring].kind = TerrainClass::obstacle;
  }
}

STEREOGRID_HD inline void drop_lone_obstacle(PolarCell* cells, SectorWalk& walk) {
  settle_block(walk.is_block_confirmed, walk, cells);
  if (walk.is_block_confirmed) return;
  walk.blocked = no_ring;
  walk.state.is_blocked = false;
}

/// Completes one sector after all walks: marks edges that neighbours confirm, withdraws others.
STEREOGRID_HD inline void settle_sector(int sector, View<const SectorWalk> walks, int rings, PolarCell* cells) {
  const SectorWalk& walk{walks(sector, 0)};
  settle_block(walk.is_block_confirmed ||
                   confirming(walks, sector, 2, &SectorWalk::blocked, walk.blocked) >= walk.block_confirmations,
               walk, cells);
  if (walk.end == no_ring) return;
  if (is_end_confirmed(sector, walks)) {
    const TerrainClass kind{walk.end_kind == GapKind::drop ? TerrainClass::drop : TerrainClass::hidden};
    for (int ring{walk.end}; ring <= walk.end_seen; ++ring) cells[ring] = PolarCell{.kind = kind};
    return;
  }
  for (int ring{walk.end}; ring < rings; ++ring) {
    if (cells[ring].kind == TerrainClass::hidden) cells[ring].kind = TerrainClass::unknown;
  }
}

/// Marks unknown cells of a ring within some sectors of an edge as hidden: at the image's border and between poles the
/// walk may have lost the ground before the edge.
STEREOGRID_HD inline void spread_hidden(int ring, View<PolarCell> cells) {
  constexpr int spread_sectors{8};
  const auto hide = [&](int begin, int end) {
    for (int sector{begin}; sector < end; ++sector) cells(ring, sector).kind = TerrainClass::hidden;
  };
  for (int begin{0}; begin < cells.height; ++begin) {
    int end{begin};
    while (end < cells.height && cells(ring, end).kind == TerrainClass::unknown) ++end;
    const bool is_edge_behind{end < cells.height && is_behind_edge(cells(ring, end))};
    const int right{is_edge_behind ? Max(end - spread_sectors, begin) : end};
    if (begin > 0 && is_behind_edge(cells(ring, begin - 1))) hide(begin, Min(begin + spread_sectors, right));
    hide(right, end);
    begin = end;
  }
}

/// Hides ground of a ring beside hidden cells while it is lower than the ground farther from them: by 2 σ where the
/// mean of a search mixes both; behind that it is steeper than any ground, too. The matcher's window mixes both levels,
/// the farther the more oblique an edge is. Last of all: it ends no ways.
STEREOGRID_HD inline void hide_ends(const WalkInput& input, int ring, View<PolarCell> cells) {
  constexpr int apart{sectors_beside + 1};
  const TerrainCamera& camera{input.camera};
  const float x{input.rings.middle_m(ring)};
  const float lower_m{2 * camera.elevation_sigma(camera.height_m, x, input.sigma_px[ring])};
  const float steep_m{Max(lower_m, input.limits.slope * apart * sector_px * x / camera.focal_px)};
  const auto hide = [&](int first, int side) {
    for (int sector{first};; sector += side) {
      const int level{sector + side * apart};
      if (level < 0 || level >= cells.height || !cells(ring, level).is_ground()) return;
      PolarCell& cell{cells(ring, sector)};
      const float fall_m{std::abs(sector - first) < sectors_beside ? lower_m : steep_m};
      if (!cell.is_ground() || cell.elevation_m > cells(ring, level).elevation_m - fall_m) return;
      cell = PolarCell{.kind = TerrainClass::hidden};
    }
  };
  for (int begin{0}; begin < cells.height;) {
    const bool is_behind{is_behind_edge(cells(ring, begin))};
    int end{begin + 1};
    while (end < cells.height && is_behind_edge(cells(ring, end)) == is_behind) ++end;
    if (!is_behind && begin > 0) hide(begin, 1);
    if (!is_behind && end < cells.height) hide(end - 1, -1);
    begin = end;
  }
}

/// Fills the sectors between `left` and `right`, `width_m` apart, if the ground of both is alike.
STEREOGRID_HD inline void fill_streak(const WalkInput& input, int ring, int left, int right, float width_m,
                                      View<PolarCell> cells) {
  const PolarCell& from{cells(ring, left)};
  const PolarCell& to{cells(ring, right)};
  const float alike_m{Max(input.limits.step_m, input.limits.slope * width_m)};
  if (std::abs(to.elevation_m - from.elevation_m) > alike_m) return;
  for (int sector{left + 1}; sector < right; ++sector) {
    const float share{static_cast<float>(sector - left) / static_cast<float>(right - left)};
    cells(ring, sector) = {std::lerp(from.elevation_m, to.elevation_m, share), std::lerp(from.slope, to.slope, share),
                           TerrainClass::drivable, from.is_firm && to.is_firm};
  }
}

/// Fills sectors of a ring without samples between two sectors of ground, where they are no wider than the ring is long
/// and than passage_width.
STEREOGRID_HD inline void fill_streaks(const WalkInput& input, int ring, View<const SectorWalk> walks,
                                       View<PolarCell> cells) {
  const float length_m{Min(input.rings.end_m(ring) - input.rings.begin_m(ring), passage_width * input.limits.height_m)};
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

/// Ways through a ring from the one before it. A way ends at edges, and where one camera sees nothing.
struct RingWays {
  STEREOGRID_HD RingWays(const WalkInput& input, int ring)
      : first{Min(static_cast<int>(input.camera.focal_baseline_pxm / input.rings.middle_m(ring)) / sector_px,
                  input.sectors)},
        narrowest{Min(static_cast<int>(std::ceil(input.limits.height_m * input.camera.focal_px /
                                                 (sector_px * input.rings.middle_m(ring)))),
                      input.sectors - first)} {}

  int first;      ///< first sector that the right camera sees
  int narrowest;  ///< sectors that are as wide as the vehicle is high
};

}  // namespace stereogrid
