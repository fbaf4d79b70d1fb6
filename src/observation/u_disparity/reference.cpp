// SPDX-License-Identifier: Apache-2.0
#include "backend/reference.hpp"

#include <algorithm>

#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

// Equations 9 to 12 for one bin, as they are written.
void count_bin(const Matches& matches, const BinRows& bins, const BinConfig& config, int u, int d,
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

int possible_at(const BinRows& bins, int u, int d) {
  const RowRange rows{bins.rows[static_cast<std::size_t>(d)]};
  return possible_in_column(rows.first, rows.last, bins.shift[static_cast<std::size_t>(u)], bins.height);
}

void infer_bin(const UDisparityTables& tables, const UDisparityWorkspace& space, int u, int d, StageImages& stages) {
  const BinConfig& config{tables.config};
  const BinConstants<float> constants{
      bin_constants(static_cast<float>(config.false_positive), static_cast<float>(config.false_negative))};
  const float visible{visibility_of(stages.visible(u, d), possible_at(space.rows, u, d))};
  const float miss{miss_of(config, stages.visible(u, d), stages.observed(u, d))};
  const int road_cells{road_cells_around(space.has_road.view(), u, d)};
  const float road{tables.road_factor[static_cast<std::size_t>(road_cells)] * miss};
  const bool blind{config.left_border && u < d + tables.half_window};
  const float obstacle{obstacle_probability(visible, 1 - miss, constants)};
  stages.visibility(u, d) = visible;
  stages.obstacle_confidence(u, d) = 1 - miss;
  stages.road_confidence(u, d) = road;
  stages.occupancy(u, d) = d == 0 || blind ? 0.5f : occupancy_probability(obstacle, road, constants);
}

// Along columns first, then along disparity; bin 0 is left out; borders repeat.
void smooth(const UDisparityTables& tables, UDisparityWorkspace& space, StageImages& stages) {
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
           UDisparityWorkspace& space, StageImages& stages) {
  const int width{matches.road.width()};
  const int disparities{stages.occupancy.height()};
  space.rows.place(rig, ground, tables.config);
  for (int d{0}; d < disparities; ++d) {
    const RowRange rows{possible_rows(rig, ground, tables.config.obstacle_height_m, d, space.rows.height)};
    stages.possible[static_cast<std::size_t>(d)] = std::max(rows.last - rows.first + 1, 0);
    for (int u{0}; u < width; ++u) {
      count_bin(matches, space.rows, tables.config, u, d, stages);
      space.has_road(u, d) = has_road_pixel(matches, u, d) ? 1 : 0;
    }
  }
  for (int d{0}; d < disparities; ++d) {
    for (int u{0}; u < width; ++u) infer_bin(tables, space, u, d, stages);
  }
  smooth(tables, space, stages);
}

}  // namespace stereogrid
