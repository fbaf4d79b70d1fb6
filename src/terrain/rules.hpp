// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "geometry/relief.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Effect of the terrain on a cell's observed occupancy.
enum class CellRule : std::uint8_t { as_observed, ground_not_seen, not_free, free, low_obstacle, obstacle, edge };

/// P(occupied) of drivable ground where the plane sees an obstacle; least P of obstacles and edges (docs/terrain.md).
constexpr float ruled_free{0.2f};
constexpr float ruled_obstacle{0.7f};
constexpr float ruled_edge{0.7f};
/// P(occupied) from which on rays alone do not make a cell without ground free.
constexpr float doubtful_free{0.2f};

STEREOGRID_HD inline float ruled(float occupancy, CellRule rule) {
  const float not_free{Max(occupancy, 0.5f)};
  if (rule == CellRule::ground_not_seen) return occupancy > doubtful_free ? not_free : occupancy;
  if (rule == CellRule::not_free) return not_free;
  if (rule == CellRule::free) return Min(occupancy, ruled_free);
  if (rule == CellRule::low_obstacle || rule == CellRule::obstacle) return Max(occupancy, ruled_obstacle);
  return rule == CellRule::edge ? Max(occupancy, ruled_edge) : occupancy;
}

/// Sixteen cells have the same value. Two comparisons instead of a call of std::memcmp.
template <class Byte>
bool are_alike(const Byte* values) {
  static_assert(sizeof(Byte) == 1);
  std::uint64_t halves[2];
  std::memcpy(halves, values, sizeof(halves));
  return halves[0] == halves[1] && halves[0] == 0x0101010101010101U * static_cast<std::uint64_t>(*values);
}

/// Calls work(begin, end, value) for all cells of a row: for sixteen of the same value, or for one.
template <class Byte, class Work>
void for_cells(const Byte* values, int cells, const Work& work) {
  constexpr int many{16};
  for (int i{0}; i < cells; i += many) {
    if (i + many <= cells && are_alike(values + i)) {
      work(i, i + many, values[i]);
      continue;
    }
    for (int k{i}; k < std::min(i + many, cells); ++k) work(k, k + 1, values[k]);
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

/// Least filtered occupancy of a cell with that rule in this frame: near observations override memory of ground that
/// looked free from afar.
inline float least_filtered(CellRule rule) {
  if (rule == CellRule::edge) return ruled_edge;
  return rule == CellRule::not_free || rule == CellRule::low_obstacle || rule == CellRule::obstacle ? 0.5f : 0.0f;
}

/// Hazards of a cell in the frames that have seen it. Bits 0 to 2: a low obstacle in the last three, bit 0 the last
/// one. Bit 3: a tall one in the last frame, bit 4: an edge.
using Hazards = std::uint8_t;
constexpr Hazards no_hazards{0};

/// Hazards after a frame that has seen the cell, with that rule.
inline Hazards after(Hazards before, CellRule rule) {
  const unsigned low{(unsigned{before} << 1U) & 7U};
  if (rule == CellRule::low_obstacle) return static_cast<Hazards>(low | 1U);
  return static_cast<Hazards>(rule == CellRule::obstacle ? 8U : rule == CellRule::edge ? 16U : low);
}

/// Least filtered occupancy. Two of three frames confirm a low obstacle: single frames mark wrong matches, and miss
/// stones as often as they find them. Rays and the filter decide about tall ones, which may move.
inline float least_filtered(Hazards hazards) {
  if ((hazards & 16U) != 0) return ruled_edge;
  if (std::popcount(hazards & 7U) >= 2) return ruled_obstacle;
  return (hazards & 9U) != 0 ? 0.5f : 0.0f;
}

/// The ground of a frame and the rules of its grids; empty: none.
struct TerrainRules {
  Relief<Host> relief;
  View<const CellRule> vehicle;
  View<const CellRule> window;
};

}  // namespace stereogrid
