// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "ground/relief.hpp"
#include "host_device.hpp"
#include "numbers.hpp"
#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"

namespace stereogrid {

/// Effect of the terrain on a cell's observed occupancy.
enum class CellRule : std::uint8_t { as_observed, ground_not_seen, not_free, free, obstacle, edge };

/// P(occupied) of drivable ground where the plane sees an obstacle; least P of obstacles and edges (docs/terrain.md).
constexpr float ruled_free{0.2f};
constexpr float ruled_obstacle{0.7f};
constexpr float ruled_edge{0.7f};
/// P(occupied) from which on rays alone do not make a cell without ground free.
constexpr float doubtful_free{0.2f};

STEREOGRID_HD inline float ruled(float occupancy, CellRule rule) {
  if (rule == CellRule::ground_not_seen) return occupancy > doubtful_free ? Max(occupancy, 0.5f) : occupancy;
  if (rule == CellRule::not_free) return Max(occupancy, 0.5f);
  if (rule == CellRule::free) return Min(occupancy, ruled_free);
  if (rule == CellRule::obstacle) return Max(occupancy, ruled_obstacle);
  return rule == CellRule::edge ? Max(occupancy, ruled_edge) : occupancy;
}

/// Least filtered occupancy in a frame with that rule: near observations override memory of ground that looked free
/// from afar.
STEREOGRID_HD inline float least_filtered(CellRule rule) {
  if (rule == CellRule::edge) return ruled_edge;
  return rule == CellRule::not_free || rule == CellRule::obstacle ? 0.5f : 0.0f;
}

/// The ground of a frame and the rules of its grids; empty: none.
struct TerrainRules {
  Relief<Host> relief;
  View<const CellRule> vehicle;
  View<const CellRule> window;
};

}  // namespace stereogrid
