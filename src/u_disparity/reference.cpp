// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>
#include <cmath>

#include "u_disparity/model.hpp"
#include "u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

// Equations 9 to 12 for one bin, as they are written.
void count_bin(const Matches& matches, const BinRows& bins, const UDisparityConfig& config, int u, int d,
               StageImages& stages) {
  int visible{0};
  int observed{0};
  const int shift{bins.shift[static_cast<std::size_t>(u)]};
  const RowRange rows{bins.rows[static_cast<std::size_t>(d)]};
  const RowRange upright{bins.upright_rows[static_cast<std::size_t>(d)]};
  for (int v{std::max(rows.first + shift, 0)}; v <= std::min(rows.last + shift, bins.height - 1); ++v) {
    const int obstacle{bin_of(matches.obstacle(u, v))};
    const int road{bin_of(matches.road(u, v))};
    if (obstacle > 0 && obstacle <= d) ++visible;
    const bool is_upright{v >= upright.first + shift && v <= upright.last + shift};
    if (obstacle > 0 && obstacle == d && is_upright) ++observed;
    if (config.road_rays == RoadRays::visible && road > 0 && road <= d) ++visible;
  }
  stages.visible(u, d) = static_cast<std::uint16_t>(visible);
  stages.observed(u, d) = static_cast<std::uint16_t>(observed);
}

bool has_road_pixel(const Matches& matches, int u, int d) {
  for (int v{0}; v < matches.road.height(); ++v) {
    if (bin_of(matches.road(u, v)) == d) return true;
  }
  return false;
}

// The same for bins finer than a pixel: a disparity between two of them belongs to both.
void count_fine_bin(const Matches& matches, const BinRows& bins, const UDisparityConfig& config, int u, int k,
                    StageImages& stages) {
  const int per_px{config.bins_per_px};
  int visible{0};
  int observed{0};
  const int shift{bins.shift[static_cast<std::size_t>(u)]};
  const RowRange rows{bins.rows[static_cast<std::size_t>(k)]};
  const RowRange upright{bins.upright_rows[static_cast<std::size_t>(k)]};
  for (int v{std::max(rows.first + shift, 0)}; v <= std::min(rows.last + shift, bins.height - 1); ++v) {
    const int obstacle{place_of_disparity(matches.obstacle(u, v), per_px)};
    const int road{place_of_disparity(matches.road(u, v), per_px)};
    if (!is_no_place(obstacle)) {
      const int arrived{parts_arrived(support_begin(obstacle, per_px), k)};
      const bool is_upright{v >= upright.first + shift && v <= upright.last + shift};
      visible += arrived;
      if (is_upright) observed += arrived - parts_arrived(support_end(obstacle, per_px), k);
    }
    if (config.road_rays == RoadRays::visible && !is_no_place(road)) {
      visible += parts_arrived(support_begin(road, per_px), k);
    }
  }
  stages.visible(u, k) = static_cast<std::uint16_t>(whole_rays(visible));
  stages.observed(u, k) = static_cast<std::uint16_t>(whole_rays(observed));
}

bool has_road_near(const Matches& matches, int bins_per_px, int u, int k) {
  for (int v{0}; v < matches.road.height(); ++v) {
    const int place{place_of_disparity(matches.road(u, v), bins_per_px)};
    if (!is_no_place(place) && is_road_of_bin(place, k, bins_per_px)) return true;
  }
  return false;
}

void count_at(const Matches& matches, const UDisparityConfig& config, int u, int d, UDisparitySpace& space,
              StageImages& stages) {
  if (config.bins_per_px == 1) {
    count_bin(matches, space.rows, config, u, d, stages);
    space.has_road(u, d) = has_road_pixel(matches, u, d) ? 1 : 0;
  } else {
    count_fine_bin(matches, space.rows, config, u, d, stages);
    space.has_road(u, d) = has_road_near(matches, config.bins_per_px, u, d) ? 1 : 0;
  }
}

int possible_at(const BinRows& bins, int u, int d) {
  const RowRange rows{bins.rows[static_cast<std::size_t>(d)]};
  return possible_in_column(rows.first, rows.last, bins.shift[static_cast<std::size_t>(u)], bins.height);
}

void infer_bin(const UDisparityTables& tables, const UDisparitySpace& space, int u, int d, StageImages& stages) {
  const UDisparityConfig& config{tables.config};
  const BinConstants<float> constants{
      bin_constants(static_cast<float>(config.false_positive), static_cast<float>(config.false_negative))};
  const float visible{visibility_of(stages.visible(u, d), possible_at(space.rows, u, d))};
  const float miss{miss_of(config, stages.visible(u, d), stages.observed(u, d))};
  const int road_cells{road_cells_around(space.has_road.view(), u, d, config.bins_per_px)};
  const float road{tables.road_factor[static_cast<std::size_t>(road_cells)] * miss};
  const bool blind{config.left_border && (u - tables.half_window) * config.bins_per_px < d};
  const float obstacle{obstacle_probability(visible, 1 - miss, constants)};
  stages.visibility(u, d) = visible;
  stages.obstacle_confidence(u, d) = 1 - miss;
  stages.road_confidence(u, d) = road;
  stages.occupancy(u, d) = d == 0 || blind ? 0.5f : occupancy_probability(obstacle, road, constants);
}

// Along columns first, then along disparity; bin 0 is left out; borders repeat.
void smooth(const UDisparityTables& tables, UDisparitySpace& space, StageImages& stages) {
  const int width{stages.occupancy.width()};
  const int disparities{stages.occupancy.height()};
  const int reach_u{static_cast<int>(tables.weights_column.size()) / 2};
  const int reach_d{static_cast<int>(tables.weights_disparity.size()) / 2};
  for (int d{1}; d < disparities; ++d) {
    for (int u{0}; u < width; ++u) {
      float sum{0};
      for (int k{-reach_u}; k <= reach_u; ++k) {
        sum += tables.weights_column[static_cast<std::size_t>(k + reach_u)] *
               stages.occupancy(std::clamp(u + k, 0, width - 1), d);
      }
      space.smooth_once(u, d) = sum;
    }
  }
  for (int u{0}; u < width; ++u) stages.occupancy_smooth(u, 0) = 0.5f;
  for (int d{1}; d < disparities; ++d) {
    for (int u{0}; u < width; ++u) {
      float sum{0};
      for (int k{-reach_d}; k <= reach_d; ++k) {
        sum += tables.weights_disparity[static_cast<std::size_t>(k + reach_d)] *
               space.smooth_once(u, std::clamp(d + k, 1, disparities - 1));
      }
      stages.occupancy_smooth(u, d) = sum;
    }
  }
}

}  // namespace

void count(Reference&, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityTables& tables,
           UDisparitySpace& space, StageImages& stages) {
  const int width{matches.road.width()};
  const int disparities{stages.occupancy.height()};
  space.rows.place(rig, ground, tables.config);
  for (int d{0}; d < disparities; ++d) {
    const double disparity{static_cast<double>(d) / tables.config.bins_per_px};
    const RowRange rows{possible_rows(rig, ground, tables.config.obstacle_height_m, disparity, space.rows.height)};
    stages.possible[static_cast<std::size_t>(d)] = std::max(rows.last - rows.first + 1, 0);
    for (int u{0}; u < width; ++u) count_at(matches, tables.config, u, d, space, stages);
  }
  for (int d{0}; d < disparities; ++d) {
    for (int u{0}; u < width; ++u) infer_bin(tables, space, u, d, stages);
  }
  smooth(tables, space, stages);
}

}  // namespace stereogrid
