// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "stereogrid/grid.hpp"
#include "stereogrid/image.hpp"
#include "terrain/gaps.hpp"
#include "terrain/model.hpp"
#include "terrain/rings.hpp"
#include "terrain/samples.hpp"
#include "terrain/trenches.hpp"

namespace stereogrid {

struct PolarCell {
  float elevation_m{std::numeric_limits<float>::quiet_NaN()};  ///< elevation of ground, or of an obstacle's top
  float slope{0};                                              ///< slope of the ground, tangent
  TerrainClass kind{TerrainClass::unknown};
  bool is_firm{false};  ///< no gap between the footprint and this ground

  [[nodiscard]] STEREOGRID_HD bool is_ground() const { return kind == TerrainClass::drivable; }
};

/// Ground that a sector's walk continues from.
struct WalkState {
  float x{0};  ///< place of the last ground, m
  float z{0};
  float slope{0};          ///< slope of the ground there, tangent
  float reached{0};        ///< ground is interpolated up to here, m
  int missing{0};          ///< rings without ground since
  bool is_alive{true};     ///< the ground is connected with the vehicle's footprint
  bool is_blocked{false};  ///< an obstacle ended the walk
  bool is_firm{true};      ///< no gap between the footprint and the ground
  float before_z{0};       ///< elevation of the ground before the bridge to this one; x = reached: there is one

  [[nodiscard]] float elevation(float at_x) const { return z + slope * (at_x - x); }
};

struct SectorWalk {
  int lost{0};            ///< ring at which the walk first lost the ground
  WalkState state{};      ///< behind the last ring that was walked
  int blocked{no_ring};   ///< ring of the obstacle that the walk met last
  int end{no_ring};       ///< ring of an edge behind which the ground is hidden
  int end_seen{no_ring};  ///< ring in which the gap was met: behind `end` by the matcher's smear
  int landing{no_ring};   ///< ring of the first visible surface behind it
  GapKind end_kind{GapKind::unknown};
  float end_fall_m{0};       ///< visible fall of the surface behind the edge
  int end_confirmations{0};  ///< number of the six neighbours that must confirm the edge
  std::optional<Trench> trench{};
  int block_confirmations{0};      ///< number of neighbours that must confirm `blocked`
  bool is_block_confirmed{false};  ///< enough neighbours confirm `blocked`
  int round{0};                    ///< last round of spread_ground() that continued the walk
};

struct WalkInput {
  const TerrainCamera& camera;
  const TerrainLimits& limits;
  const Rings& rings;
  const TerrainSamples& samples;
  const float* sigma_px;  ///< by ring
  int checked_rings;      ///< rings whose noise is low enough for edges and obstacles
  float window_rows;      ///< rows over which the matcher smears a jump
  FirstGround prior{};
};

/// Walks along one sector from the vehicle outwards, until it loses the ground. `trench`: the sector's.
void walk_sector(const WalkInput& input, int sector, const std::optional<Trench>& trench, View<PolarCell> cells,
                 SectorWalk& walk);

/// Enough neighbours have their edges near that of the sector.
[[nodiscard]] bool is_end_confirmed(int sector, View<const SectorWalk> walks);

/// Compares the obstacle that ended a walk with those of its neighbours, once all sectors have been walked.
void confirm_block(int sector, View<SectorWalk> walks);

/// Continues the walks of all sectors that have lost the ground, ring by ring, from the ground of neighbours: in rounds
/// until none changes, each from the ground of those before, so that the order does not matter. `cells`: (ring,
/// sector).
void spread_ground(const WalkInput& input, View<PolarCell> cells, View<SectorWalk> walks);

/// Completes one sector after all walks: marks edges that neighbours confirm, withdraws others.
void settle_sector(int sector, View<const SectorWalk> walks, int rings, PolarCell* cells);

/// Marks unknown cells within some sectors of an edge as hidden: at the image's border and between poles the walk may
/// have lost the ground before the edge.
void spread_hidden(int rings, View<PolarCell> cells);

/// Fills sectors without samples between two sectors of ground, where they are no wider than the ring is long and than
/// passage_width.
void fill_streaks(const WalkInput& input, View<const SectorWalk> walks, View<PolarCell> cells);

/// Hides ground that no way as wide as the vehicle's height reaches from the footprint. A way ends at edges, and where
/// one camera sees nothing. `reached`: working memory, (sector, 0).
void hide_unconnected(const WalkInput& input, View<PolarCell> cells, View<std::uint8_t> reached);

/// Ground and obstacle samples of a ring, relative to an expected elevation.
struct RingSamples {
  int ground{0};
  float ground_z{0};  ///< sum
  int above{0};
  float top{-1e3f};         ///< highest sample of an obstacle
  bool is_standing{false};  ///< the obstacle begins near the ground
};

/// One ring of a sector. `z` and `slope` describe the surface expected at the ring's middle.
struct RingView {
  RingView(const WalkInput& input, const SectorRows& sector, int index);

  [[nodiscard]] bool is_upright(int v) const;
  [[nodiscard]] RingSamples gather(float z, float slope, float tolerance) const;
  [[nodiscard]] bool has_ground(const RingSamples& samples, float z, float slope) const;
  [[nodiscard]] bool has_obstacle(const RingSamples& samples, float z) const;
  /// First row, upwards, with a sample behind and below the expected ground; no_row: fewer than half of the ground's
  /// rows have one. `z_near`, `z_far`: elevation of the ground at both ends.
  [[nodiscard]] int row_through(float z_near, float z_far) const;
  [[nodiscard]] float predicted_rows(float z, float slope) const;
  [[nodiscard]] bool is_checked() const { return ring < in->checked_rings; }
  /// Noise of the height over the surface, m.
  [[nodiscard]] float sigma(float z, float slope) const {
    return in->camera.height_sigma(in->camera.height_m - z, slope, x, sigma_px);
  }

  const WalkInput* in;
  SectorRows rows;
  int ring;
  float begin_m;
  float end_m;
  float x;  ///< middle of the ring
  float sigma_px;
};

}  // namespace stereogrid
