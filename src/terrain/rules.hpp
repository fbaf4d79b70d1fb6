// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "geometry/grid_in_vehicle.hpp"
#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Effect of the terrain on a cell's observed occupancy.
enum class CellRule : std::uint8_t { as_observed, ground_not_seen, not_free, obstacle, edge };

/// Rule of a cell with that ground.
STEREOGRID_HD inline CellRule rule_of(TerrainClass kind) {
  switch (kind) {
    case TerrainClass::obstacle:
      return CellRule::obstacle;
    case TerrainClass::drop:
      return CellRule::edge;
    case TerrainClass::hidden:
      return CellRule::not_free;
    case TerrainClass::drivable:
      return CellRule::as_observed;
    case TerrainClass::unknown:
      break;
  }
  return CellRule::ground_not_seen;
}

/// Least P(occupied) of obstacles and edges (docs/terrain.md).
constexpr float ruled_obstacle{0.7f};
constexpr float ruled_edge{0.7f};
/// P(occupied) from which on rays alone do not make a cell without ground free.
constexpr float uncertain_free{0.2f};

STEREOGRID_HD inline float ruled(float occupancy, CellRule rule) {
  const float not_free{Max(occupancy, 0.5f)};
  if (rule == CellRule::ground_not_seen) return occupancy > uncertain_free ? not_free : occupancy;
  if (rule == CellRule::not_free) return not_free;
  if (rule == CellRule::obstacle) return Max(occupancy, ruled_obstacle);
  return rule == CellRule::edge ? Max(occupancy, ruled_edge) : occupancy;
}

/// Rule of a cell that two cameras see: hazards count, and ground that one of them sees.
inline CellRule combined(CellRule one, CellRule other) {
  constexpr std::array<int, 5> ranks{2, 0, 1, 3, 4};  // by CellRule
  const auto rank = [&](CellRule rule) { return ranks[static_cast<std::size_t>(rule)]; };
  return rank(one) < rank(other) ? other : one;
}

/// Likewise the class of its ground.
inline TerrainClass combined(TerrainClass one, TerrainClass other) {
  constexpr std::array<int, 5> ranks{0, 2, 3, 4, 1};  // by TerrainClass
  const auto rank = [&](TerrainClass kind) { return ranks[static_cast<std::size_t>(kind)]; };
  return rank(one) < rank(other) ? other : one;
}

/// Sixteen cells have the same rule, or other byte. Two comparisons instead of a call of std::memcmp.
template <class Byte>
bool are_alike(const Byte* rules) {
  static_assert(sizeof(Byte) == 1);
  std::uint64_t halves[2];
  std::memcpy(halves, rules, sizeof(halves));
  return halves[0] == halves[1] && halves[0] == 0x0101010101010101U * (halves[0] & 0xffU);
}

/// Calls work(begin, end, rule) for all cells of a row: for sixteen of the same rule, or other byte, or for one.
template <class Byte, class Work>
void for_cells(const Byte* rules, int cells, const Work& work) {
  constexpr int many{16};
  for (int i{0}; i < cells; i += many) {
    if (i + many <= cells && are_alike(rules + i)) {
      work(i, i + many, rules[i]);
      continue;
    }
    for (int k{i}; k < std::min(i + many, cells); ++k) work(k, k + 1, rules[k]);
  }
}

/// Applies ruled() to a row.
inline void apply_rules(const CellRule* rules, int cells, float* occupancy) {
  for_cells(rules, cells, [occupancy](int begin, int end, CellRule rule) {
    const auto apply = [&](CellRule to_all) {
      for (int i{begin}; i < end; ++i) occupancy[i] = ruled(occupancy[i], to_all);
    };
    // the rules of most cells as constants, with which the loop becomes vectors
    if (rule == CellRule::ground_not_seen) return apply(CellRule::ground_not_seen);
    rule == CellRule::not_free ? apply(CellRule::not_free) : apply(rule);
  });
}

/// Makes the cell of a low obstacle one; false: it is one, or an edge.
STEREOGRID_HD inline bool mark_obstacle(CellRule& rule) {
  if (rule == CellRule::edge || rule == CellRule::obstacle) return false;
  rule = CellRule::obstacle;
  return true;
}

/// Cells of the vehicle's grid whose centres lie in a cell of the window.
class CellsWithin {
 public:
  CellsWithin(const GridGeometry& vehicle_grid, const GridInVehicle& window)
      : grid_{vehicle_grid},
        window_{window},
        places_{{vehicle_grid, -window.cos_yaw * window.x_m - window.sin_yaw * window.y_m,
                 window.sin_yaw * window.x_m - window.cos_yaw * window.y_m, window.cos_yaw, -window.sin_yaw},
                {window.grid.x_min_m, window.grid.y_min_m},
                window.grid.cell_size_m} {}

  template <class Work>
  STEREOGRID_HD void for_cells(int x, int y, const Work& work) const {
    const Point2 at{window_.centre(x, y)};
    const int near_x{static_cast<int>(std::floor((at.x - grid_.x_min_m) / grid_.cell_size_m))};
    const int near_y{static_cast<int>(std::floor((at.y - grid_.y_min_m) / grid_.cell_size_m))};
    for (int iy{std::max(near_y - 1, 0)}; iy <= std::min(near_y + 1, grid_.ny - 1); ++iy) {
      for (int ix{std::max(near_x - 1, 0)}; ix <= std::min(near_x + 1, grid_.nx - 1); ++ix) {
        if (static_cast<int>(places_.x_of(ix, iy)) == x && static_cast<int>(places_.y_of(ix, iy)) == y) work(ix, iy);
      }
    }
  }

 private:
  GridGeometry grid_;
  GridInVehicle window_;
  CellPlaces places_;
};

/// Bounds of a cell's filtered occupancy, by its rule, its hazards and its witness in the window.
enum CellBound : std::uint8_t {
  bound_unknown = 1,
  bound_occupied = 2,
  bound_hazard = 4,  ///< in memory, or low: the same where a frame has observed the cell
};
static_assert(ruled_edge == ruled_obstacle);

/// Bound of a cell with that rule: near observations override memory of ground that looked free from afar.
constexpr std::uint8_t bound_of(CellRule rule) {
  if (rule == CellRule::edge) return bound_occupied;
  return rule == CellRule::not_free || rule == CellRule::obstacle ? bound_unknown : 0;
}

/// Without branches, for vectors.
STEREOGRID_HD inline float bounded(float occupancy, std::uint8_t bounds, float age_s) {
  const int bits{bounds};
  const float of_hazard{age_s < INFINITY ? ruled_obstacle : 0.0f};
  const float of_rule{
      Max((bits & bound_occupied) != 0 ? ruled_obstacle : 0.0f, (bits & bound_unknown) != 0 ? 0.5f : 0.0f)};
  return Max(occupancy, Max(of_rule, (bits & bound_hazard) != 0 ? of_hazard : 0.0f));
}

/// Bounds a cell of the vehicle's grid. `witness`: that of a free cell; then the cell's. Memory is no witness of a cell
/// that no frame has observed.
STEREOGRID_HD inline void bound_cell(std::uint8_t bounds, float age_s, float& observed, float& occupancy,
                                     CellWitness& witness) {
  if (bounds != 0) occupancy = bounded(occupancy, bounds, age_s);
  const Witness kind{witness.kind()};
  const bool is_unseen{!(age_s < INFINITY) && Min(observed, occupancy) >= 0.5f};
  if (witness.allows_free() && !(kind == Witness::memory && is_unseen)) return;
  witness = CellWitness::of(observed < 0.5f ? Witness::passable : Witness::none);
  observed = Max(observed, 0.5f);
  occupancy = Max(occupancy, 0.5f);
}

/// Bounds of the filtered grids, CellBound; empty: none.
template <class Space>
struct GridBounds {
  View<const std::uint8_t, Space> vehicle;
  View<const std::uint8_t, Space> window;
};

/// The ground of a frame and the rules of its grids; empty: none.
struct TerrainRules {
  Relief<Host> relief;
  View<const CellRule> vehicle;
  View<const CellRule> window;
};

}  // namespace stereogrid
