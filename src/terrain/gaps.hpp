// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "host_device.hpp"
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

/// Growth of the disparity per row up to which a surface behind a gap is upright, in that of a level one; chosen on
/// ditches in ramps.
constexpr float upright_growth{0.35f};
constexpr int landing_rows{6};
constexpr int landing_samples_min{6};

/// Line d = at_gap + per_row·(row − gap's row − ½) through the samples behind a gap.
struct Landing {
  float at_gap{0};
  float per_row{0};
  bool is_found{false};
};

// Rows within the smear mix both surfaces and are left out.
STEREOGRID_HD inline Landing landing_of(const std::array<SectorRows, 3>& sectors, int gap_row, int smear) {
  float n{0};
  float i1{0};
  float i2{0};
  float d1{0};
  float di{0};
  for (int i{-smear}; i > -smear - landing_rows; --i) {
    if (gap_row + i < sectors[1].first_row) break;
    for (const SectorRows& rows : sectors) {
      const float d{rows.disparity[gap_row + i]};
      if (!(d > 0)) continue;
      const auto offset = static_cast<float>(i);
      n += 1;
      i1 += offset;
      i2 += offset * offset;
      d1 += d;
      di += d * offset;
    }
  }
  const float spread{n * i2 - i1 * i1};
  if (n < landing_samples_min || !(spread > 0)) return {};
  const float per_row{(n * di - i1 * d1) / spread};
  return {(d1 - per_row * i1) / n + 0.5f * per_row, per_row, true};
}

/// `rows`: the sector, in the middle, and its neighbours.
STEREOGRID_HD inline Gap classify_gap(const TerrainCamera& camera, const TerrainLimits& limits,
                                      const std::array<SectorRows, 3>& rows, const GapFront& front) {
  const float t{rows[1].tangent(static_cast<float>(front.row) + 0.5f)};
  const float h{camera.height_m - front.z};
  const float line_h{h + front.rise * front.x};  // height over the rising ground's line at x = 0
  Gap gap;
  gap.edge_x = h / t;
  const Landing landing{landing_of(rows, front.row, static_cast<int>(front.window_rows / 2) + 1)};
  if (!landing.is_found) return gap;
  gap.landing_x = camera.range(std::max(landing.at_gap, 0.1f));
  gap.landing_z = camera.height_m - t * gap.landing_x;
  const float drop_m{front.z - gap.landing_z};
  gap.slope = landing.per_row > 0 ? camera.slope_of(landing.per_row, h, gap.edge_x) : 1e3f;
  const float landing_h{camera.height_m - gap.landing_z};
  const bool is_upright{landing.per_row < upright_growth * camera.level_growth(landing_h)};
  const float sigma_z{camera.elevation_sigma(landing_h, gap.landing_x, front.sigma_px)};
  const float smear_m{front.window_rows / 2 * camera.tangent_per_v * gap.landing_x};
  const bool is_far_wall{is_upright && drop_m > smear_m &&
                         gap.landing_x - gap.edge_x > 2 * camera.range_sigma(gap.edge_x, front.sigma_px)};
  const bool is_face{is_upright && (t + front.rise) * gap.landing_x - line_h > limits.step_m + 2 * sigma_z};
  if (is_face || (t >= limits.drop_slope && (drop_m > limits.step_m + 2 * sigma_z || is_far_wall))) {
    gap.kind = GapKind::drop;
  } else if (drop_m < 0.9f * limits.step_m + sigma_z) {
    gap.kind = is_upright ? GapKind::none : GapKind::bridge;
  }
  return gap;
}

}  // namespace stereogrid
