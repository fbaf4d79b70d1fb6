// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>

#include "stereogrid/image.hpp"
#include "terrain/gaps.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Cell of the polar grid.
struct PolarCell {
  float elevation_m{std::numeric_limits<float>::quiet_NaN()};  ///< of ground; of an obstacle's top
  float slope{0};                                              ///< of the ground
  TerrainClass kind{TerrainClass::unknown};

  [[nodiscard]] bool is_ground() const { return kind == TerrainClass::drivable; }
};

/// Ground that a sector's walk continues from.
struct WalkState {
  float x{0};  ///< of the last ground, m
  float z{0};
  float slope{0};          ///< of the ground there, tangent
  float reached{0};        ///< ground is interpolated up to here, m
  int missing{0};          ///< rings without ground since
  bool is_alive{true};     ///< the ground is connected with the vehicle's footprint
  bool is_blocked{false};  ///< by an obstacle

  [[nodiscard]] float elevation(float at_x) const { return z + slope * (at_x - x); }
};

/// Result of one sector's walk.
struct SectorWalk {
  int first_lost{0};  ///< ring at which the walk first lost the ground
  WalkState at_first_lost{};
  int end{no_ring};       ///< ring of an edge behind which the ground is hidden
  int end_seen{no_ring};  ///< ring in which the gap was met: behind `end` by the matcher's smear
  GapKind end_kind{GapKind::unknown};
};

/// What all sectors' walks read.
struct WalkInput {
  const TerrainCamera& camera;
  const TerrainLimits& limits;
  const Rings& rings;
  const TerrainSamples& samples;
  const float* sigma_px;         ///< by ring
  int judged_rings;              ///< rings whose noise is low enough for edges and obstacles
  float window_rows;             ///< rows over which the matcher smears a jump
  View<const PolarCell> before;  ///< of the sweep before: (ring, sector)
};

/// Walks along one sector from the vehicle outwards. The first sweep starts at the footprint. Later ones
/// (`is_first_sweep` false) start where the sector first lost the ground and continue from neighbours of the sweep
/// before.
void walk_sector(const WalkInput& input, int sector, bool is_first_sweep, PolarCell* cells, SectorWalk& walk);

/// Completes one sector after all walks: marks edges that neighbours confirm; hides what lies behind most neighbours'
/// edges; takes back an edge that no neighbour confirms.
void settle_sector(int sector, View<const SectorWalk> walks, int rings, PolarCell* cells);

}  // namespace stereogrid
