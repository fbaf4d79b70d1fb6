// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "terrain/model.hpp"
#include "terrain/samples.hpp"

namespace stereogrid {

/// Kinds of a gap between ground and the next visible surface behind it.
enum class GapKind : std::uint8_t {
  none,     ///< not lower: an obstacle's foot, or noise
  unknown,  ///< lower ground, too far to distinguish a drop from a slope
  bridge,   ///< a step that the vehicle can drive down
  drop,     ///< proved or assumed by drop_slope
};

/// Surface behind a gap.
struct Gap {
  GapKind kind{GapKind::unknown};
  float edge_x{0};     ///< last visible point of the ground, m
  float mark_x{0};     ///< the edge without the matcher's smear
  float landing_x{0};  ///< first visible point behind, m
  float landing_z{0};
  float slope{0};  ///< slope of the surface behind, tangent
};

struct GapFront {
  int row;            ///< first row, upwards, with samples behind the gap
  float x;            ///< last ground, m
  float z;            ///< elevation of the ground at the edge, m
  float rise;         ///< slope of the ground there where it rises, else 0, tangent
  float sigma_px;     ///< noise of disparities there
  float window_rows;  ///< rows over which the matcher smears a jump
};

/// `rows`: the sector, in the middle, and its neighbours.
Gap classify_gap(const TerrainCamera& camera, const TerrainLimits& limits, const std::array<SectorRows, 3>& rows,
                 const GapFront& front);

}  // namespace stereogrid
