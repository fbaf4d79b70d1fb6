// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "terrain/gaps.hpp"

#include <algorithm>
#include <cmath>

namespace stereogrid {
namespace {

constexpr int landing_rows{6};
constexpr int landing_samples_min{6};
constexpr float jump_min_px{0.9f};
constexpr float trench_begin_sigmas{1};  ///< noise of the height over the ground
constexpr float trench_depth_sigmas{2.5f};
constexpr float trench_depth_steps{0.3f};  ///< visible depth, in largest steps of the vehicle
constexpr float trench_wall_growth{0.5f};  ///< growth of the disparity per row, relative to a level surface
constexpr int trench_wall_rows{4};

/// Line d = at_gap + per_row·(row − gap's row − ½) through the samples behind a gap.
struct Landing {
  float at_gap{0};
  float per_row{0};
  bool is_found{false};
};

// Mean disparity of a row's samples, at least two; 0: none.
float mean_disparity(const std::array<SectorRows, 3>& sectors, int row) {
  float sum{0};
  float count{0};
  for (const SectorRows& rows : sectors) {
    if (!(rows.disparity[row] > 0)) continue;
    sum += rows.disparity[row];
    count += 1;
  }
  return count < 2 ? 0 : sum / count;
}

// Rows within the smear mix both surfaces and are left out.
Landing landing_of(const std::array<SectorRows, 3>& sectors, int gap_row, int smear) {
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

}  // namespace

Gap classify_gap(const TerrainCamera& camera, const TerrainLimits& limits, const std::array<SectorRows, 3>& rows,
                 const GapFront& front) {
  const float t{rows[1].tangent(static_cast<float>(front.row) + 0.5f)};
  const float h{camera.height_m - front.z};
  Gap gap;
  gap.edge_x = h / t;
  gap.mark_x = h / rows[1].tangent(static_cast<float>(front.row) + 0.5f + front.window_rows / 2);
  const Landing landing{landing_of(rows, front.row, static_cast<int>(front.window_rows / 2) + 1)};
  if (!landing.is_found) return gap;
  const float jump_px{camera.focal_baseline_pxm / gap.edge_x - landing.at_gap};
  gap.landing_x = camera.range(std::max(landing.at_gap, 0.1f));
  gap.landing_z = camera.height_m - t * gap.landing_x;
  const float drop_m{front.z - gap.landing_z};
  gap.slope = landing.per_row > 0 ? camera.slope_of(landing.per_row, h, gap.edge_x) : 1e3f;
  const float landing_h{camera.height_m - gap.landing_z};
  const bool is_upright{landing.per_row < 0.35f * camera.level_growth(landing_h)};

  const bool grows{landing.per_row > 0.6f * camera.level_growth(h)};
  if (grows && jump_px < std::max(4 * front.sigma_px, jump_min_px) && std::abs(gap.slope) < limits.slope) {
    gap.kind = GapKind::descent;
    return gap;
  }
  const float sigma_z{camera.elevation_sigma(landing_h, gap.landing_x, front.sigma_px)};
  const float smear_m{front.window_rows / 2 * camera.tangent_per_v * gap.landing_x};
  const bool is_far_wall{is_upright && drop_m > std::max(0.3f * limits.step_m, smear_m) &&
                         gap.landing_x - gap.edge_x > 2 * camera.range_sigma(gap.edge_x, front.sigma_px)};
  if (t >= limits.drop_slope && (drop_m > limits.step_m + 2 * sigma_z || is_far_wall)) {
    gap.kind = GapKind::drop;
  } else if (drop_m < 0.9f * limits.step_m + sigma_z && !is_upright &&
             gap.landing_x - gap.edge_x < 1.3f * gap.edge_x * limits.step_m / h) {
    gap.kind = GapKind::bridge;
  } else if (drop_m < 0.9f * limits.step_m + sigma_z) {
    gap.kind = GapKind::none;
  }
  return gap;
}

Gap find_trench(const TerrainCamera& camera, const TerrainLimits& limits, const std::array<SectorRows, 3>& rows,
                const TrenchFront& front) {
  const Gap none{.kind = GapKind::none};
  const float h{camera.height_m - front.z};
  Gap gap{.kind = GapKind::drop};
  int begin{no_row};
  int lowest{no_row};
  float depth{0};
  float lowest_d{0};
  const int last{std::max(front.last_row - 3 * static_cast<int>(front.window_rows), rows[1].first_row)};
  for (int v{front.first_row}; v >= last; --v) {
    const float d{mean_disparity(rows, v)};
    if (!(d > 0)) continue;
    const float x{camera.range(d)};
    const float z{camera.height_m - rows[1].tangent(static_cast<float>(v)) * x};
    const float below{front.z + front.slope * (x - front.x) - z};
    const float sigma{camera.height_sigma(h, front.slope, x, front.sigma_px)};
    if (below >= trench_begin_sigmas * sigma) {
      if (begin == no_row) begin = v;
      if (below > depth) {
        depth = below;
        lowest = v;
        lowest_d = d;
        gap.landing_x = x;
        gap.landing_z = z;
      }
    } else if (depth > std::max(trench_depth_steps * limits.step_m, trench_depth_sigmas * sigma)) {
      const int wall_rows{lowest - v};
      const float wall_growth{(lowest_d - d) / static_cast<float>(wall_rows)};
      const float row{static_cast<float>(begin) + 0.5f};
      gap.edge_x = gap.mark_x = h / rows[1].tangent(row - front.window_rows / 4);
      const bool is_trench{
          wall_rows >= trench_wall_rows && wall_growth <= trench_wall_growth * camera.level_growth(h) &&
          static_cast<float>(begin - lowest) <= front.window_rows && rows[1].tangent(row) >= limits.drop_slope};
      return is_trench ? gap : none;
    } else {
      begin = no_row;
      depth = 0;
    }
    if (begin == no_row && v <= front.last_row) return none;
  }
  return none;
}

}  // namespace stereogrid
