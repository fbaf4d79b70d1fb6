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

// Mean elevation of the ground in rings begin … end − 1; NaN: none.
float ground_between(const PolarCell* cells, int begin, int end) {
  float sum{0};
  float count{0};
  for (int ring{std::max(begin, 0)}; ring < end; ++ring) {
    if (!cells[ring].is_ground()) continue;
    sum += cells[ring].elevation_m;
    count += 1;
  }
  return sum / count;
}

// Behind an edge in `ring` that falls by `fall_m`, beyond the matcher's smear, the ground of the cells is lower by most
// of that.
bool has_fallen(const WalkInput& input, const PolarCell* cells, int ring, float fall_m) {
  constexpr int mean_rings{3};
  constexpr float share{0.6f};
  const TerrainCamera& camera{input.camera};
  const float before_m{ground_between(cells, ring - mean_rings, ring)};
  const float tangent{camera.height_m / input.rings.begin_m(ring) - input.window_rows * camera.tangent_per_v};
  if (!(tangent > 0)) return false;
  const int behind{input.rings.at_disparity(camera.focal_baseline_pxm * tangent / (camera.height_m + fall_m))};
  if (behind == no_ring) return false;
  const float behind_m{ground_between(cells, behind, std::min(behind + mean_rings, input.rings.count()))};
  return before_m - behind_m > share * fall_m;  // false: NaN
}

// Sector of a confirmed edge that another sector passes by: between edges in `ring`, or between one and the image's
// border, where the passage is narrow or its ground falls as behind the edges. The sector itself: none.
int passed_edge(const WalkInput& input, View<const SectorWalk> walks, int sector, const PolarCell* cells, int ring) {
  constexpr float widest_passage{0.25f};  // relative to the vehicle's height
  constexpr float widest_at_border{0.5f};
  constexpr float widest_fallen{0.8f};
  constexpr int edge_confirmations{3};
  const int left{edge_beside(walks, sector, -1, ring)};
  const int right{edge_beside(walks, sector, 1, ring)};
  const auto is_confirmed = [&](int edge) {
    return edge != sector && confirming(walks, edge, 3, &SectorWalk::end, ring) >= edge_confirmations;
  };
  const int edge{is_confirmed(left) ? left : is_confirmed(right) ? right : sector};
  if (edge == sector) return sector;
  const bool is_at_border{left == sector || right == sector};
  const int seen{static_cast<int>(input.camera.focal_baseline_pxm / input.rings.middle_m(ring)) / sector_px};
  const int first{left == sector ? std::min(seen, sector) : left + 1};  // the right camera does not see those before
  const int end{right == sector ? walks.width : right};
  const float width{static_cast<float>((end - first) * sector_px) * input.rings.middle_m(ring) /
                    (input.camera.focal_px * input.limits.height_m)};
  if (width <= (is_at_border ? widest_at_border : widest_passage)) return edge;
  const float fall_m{std::min(walks(left == sector ? right : left, 0).end_fall_m,
                              walks(right == sector ? left : right, 0).end_fall_m)};
  const bool is_fallen{has_fallen(input, cells, ring, std::max(fall_m, input.limits.step_m))};
  return width <= widest_fallen && is_fallen ? edge : sector;
}

// Ends a walk that passes by the nearest edges beside it.
void set_passage(const WalkInput& input, View<SectorWalk> walks, int sector, const PolarCell* cells) {
  int ring{no_ring};
  for (const int side : {-1, 1}) {
    const int beside{edge_beside(walks, sector, side, no_ring)};
    if (beside != sector && (ring == no_ring || walks(beside, 0).end < ring)) ring = walks(beside, 0).end;
  }
  SectorWalk& walk{walks(sector, 0)};
  walk.passage_end = no_ring;
  if (ring == no_ring || (walk.end != no_ring && walk.end <= ring + neighbour_rings)) return;
  walk.passage_edge = passed_edge(input, walks, sector, cells, ring);
  if (walk.passage_edge != sector) walk.passage_end = ring;
}

}  // namespace

void compare_walks(const WalkInput& input, int sector, const PolarCell* cells, View<SectorWalk> walks) {
  SectorWalk& walk{walks(sector, 0)};
  set_passage(input, walks, sector, cells);
  walk.is_block_confirmed =
      confirming(walks, sector, 2, &SectorWalk::blocked, walk.blocked) >= walk.block_confirmations;
}

void end_in_passage(const WalkInput& input, int sector, View<PolarCell> cells, View<SectorWalk> walks) {
  constexpr int noise_rings{1};
  SectorWalk& walk{walks(sector, 0)};
  if (walk.passage_end == no_ring) return;
  const int last{std::min(walk.passage_end + noise_rings, input.rings.count() - 1)};
  const bool is_met{walk.lost <= last};
  if (is_met && walk.state.is_blocked) return;
  const SectorWalk& edge{walks(walk.passage_edge, 0)};
  walk.end = walk.end_seen = last;
  walk.end_kind = edge.end_kind;
  walk.end_fall_m = edge.end_fall_m;
  walk.end_confirmations = edge.end_confirmations;
  if (is_met) return;
  std::fill(cells.row(sector) + last, cells.row(sector) + input.rings.count(), PolarCell{});
  cells(last, sector).kind = TerrainClass::hidden;
  walk.lost = last;
  walk.state.is_alive = false;
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

bool spread_to(const PolarCell* from, int rings, PolarCell* cells) {
  bool is_spread{false};
  for (int ring{0}; ring < rings; ++ring) {
    const bool is_behind_edge{from[ring].kind == TerrainClass::hidden || from[ring].kind == TerrainClass::drop};
    if (!is_behind_edge || cells[ring].kind != TerrainClass::unknown) continue;
    cells[ring].kind = TerrainClass::hidden;
    is_spread = true;
  }
  return is_spread;
}

}  // namespace

void spread_hidden(int rings, View<PolarCell> cells) {
  constexpr int spread_sectors{8};
  bool is_spread{true};
  for (int step{0}; step < spread_sectors && is_spread; ++step) {
    is_spread = false;
    for (int sector{cells.height - 1}; sector > 0; --sector)
      is_spread |= spread_to(cells.row(sector - 1), rings, cells.row(sector));
    for (int sector{0}; sector + 1 < cells.height; ++sector)
      is_spread |= spread_to(cells.row(sector + 1), rings, cells.row(sector));
  }
}

}  // namespace stereogrid
