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
  if (confirming(walks, sector, 3, &SectorWalk::end, walk.end) >= walk.end_confirmations) {
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

/// Sectors without samples between two sectors of ground.
class Streaks {
 public:
  Streaks(const WalkInput& input, View<const SectorWalk> walks, View<PolarCell> cells)
      : in_{input}, walks_{walks}, cells_{cells} {}

  /// Fills those of a ring that are no wider than the ring is long.
  void fill(int ring) {
    const float length_m{
        std::min(in_.rings.end_m(ring) - in_.rings.begin_m(ring), passage_width * in_.limits.height_m)};
    const float sector_m{sector_px * in_.rings.middle_m(ring) / in_.camera.focal_px};
    const int widest{static_cast<int>(length_m / sector_m)};
    int ground{cells_.height};  // last one
    for (int sector{0}; sector < cells_.height; ++sector) {
      if (cells_(ring, sector).is_ground()) {
        if (sector - ground > 1 && sector - ground - 1 <= widest) fill(ring, ground, sector, sector_m);
        ground = sector;
      } else if (cells_(ring, sector).kind != TerrainClass::unknown || walks_(sector, 0).state.is_blocked) {
        ground = cells_.height;
      }
    }
  }

 private:
  void fill(int ring, int left, int right, float sector_m) {
    const PolarCell& from{cells_(ring, left)};
    const PolarCell& to{cells_(ring, right)};
    const float width_m{static_cast<float>(right - left) * sector_m};
    if (std::abs(to.elevation_m - from.elevation_m) > std::max(in_.limits.step_m, in_.limits.slope * width_m)) return;
    for (int sector{left + 1}; sector < right; ++sector) {
      const float share{static_cast<float>(sector - left) / static_cast<float>(right - left)};
      cells_(ring, sector) = {std::lerp(from.elevation_m, to.elevation_m, share),
                              std::lerp(from.slope, to.slope, share), TerrainClass::drivable,
                              from.is_firm && to.is_firm};
    }
  }

  const WalkInput& in_;
  View<const SectorWalk> walks_;
  View<PolarCell> cells_;
};

/// Sectors that a way from the footprint reaches, from ring to ring.
class Ways {
 public:
  Ways(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached)
      : in_{input}, cells_{cells}, reached_{reached.row(0)} {
    std::fill_n(reached_, cells.height, std::uint8_t{1});
  }

  /// Hides the ground of a ring that no way reaches.
  void enter(int ring) {
    const float x{in_.rings.middle_m(ring)};
    first_ = std::min(static_cast<int>(in_.camera.focal_baseline_pxm / x) / sector_px, cells_.height);
    const float width{in_.limits.height_m * in_.camera.focal_px / (sector_px * x)};
    sectors_ = std::min(static_cast<int>(std::ceil(width)), cells_.height - first_);
    for (int begin{0}; begin < cells_.height;) {
      const bool is_behind{is_behind_edge(cells_(ring, begin))};
      int end{begin + 1};
      while (end < cells_.height && is_behind_edge(cells_(ring, end)) == is_behind) ++end;
      const bool is_reached{!is_behind && reached_before(begin, end) >= sectors_};
      if (!is_behind && !is_reached) hide(ring, begin, end);
      std::fill(reached_ + begin, reached_ + end, static_cast<std::uint8_t>(is_reached));
      begin = end;
    }
  }

 private:
  /// Number of those sectors that were reached in the ring before.
  [[nodiscard]] int reached_before(int begin, int end) const {
    begin = std::max(begin, first_);
    return begin < end ? static_cast<int>(std::count(reached_ + begin, reached_ + end, 1)) : 0;
  }
  void hide(int ring, int begin, int end) {
    for (int sector{begin}; sector < end; ++sector)
      if (cells_(ring, sector).is_ground()) cells_(ring, sector) = PolarCell{.kind = TerrainClass::hidden};
  }

  const WalkInput& in_;
  View<PolarCell> cells_;
  std::uint8_t* reached_;  ///< by sector
  int sectors_{0};         ///< number in the narrowest way, at most all of the ring
  int first_{0};           ///< the right camera sees none before
};

}  // namespace

void fill_streaks(const WalkInput& input, View<const SectorWalk> walks, View<PolarCell> cells) {
  Streaks streaks{input, walks, cells};
  for (int ring{0}; ring < input.rings.count(); ++ring) streaks.fill(ring);
}

void hide_unconnected(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached) {
  Ways ways{input, cells, reached};
  for (int ring{0}; ring < input.rings.count(); ++ring) ways.enter(ring);
}

}  // namespace stereogrid
