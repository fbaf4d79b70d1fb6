// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <cmath>

#include "u_disparity/model.hpp"
#include "u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

constexpr int columns_grain{64};
constexpr int bins_grain{8};

// For one row the bins that it is possible for are an interval, because both ends of S_P(d) move monotonously with d.
void find_bins_of_rows(const Rig& rig, const Ground& ground, const UDisparityTables& tables, int disparities,
                       UDisparitySpace& space, std::vector<int>& possible) {
  const int height{static_cast<int>(space.bins_of_row.size())};
  std::fill(space.bins_of_row.begin(), space.bins_of_row.end(), BinRange{disparities, -1});
  for (int d{0}; d < disparities; ++d) {
    const RowRange rows{possible_rows(rig, ground, tables.config.obstacle_height_m, d, height)};
    possible[static_cast<std::size_t>(d)] = std::max(rows.last - rows.first + 1, 0);
    for (int v{rows.first}; v <= rows.last; ++v) {
      BinRange& bins{space.bins_of_row[static_cast<std::size_t>(v)]};
      bins.first = std::min(bins.first, d);
      bins.last = d;
    }
  }
}

// A pixel that ends at bin `end` is a ray through every bin from there on: one step up, one step down.
void add_ray(int end, BinRange bins, int u, int weight, Image<std::int16_t>& steps) {
  const int from{std::max(end, bins.first)};
  if (from > bins.last) return;
  steps(u, from) = static_cast<std::int16_t>(steps(u, from) + weight);
  steps(u, bins.last + 1) = static_cast<std::int16_t>(steps(u, bins.last + 1) - weight);
}

// Parts of rays to rays.
void round_counts(int begin, int end, StageImages& stages) {
  for (int d{0}; d < stages.occupancy.height(); ++d) {
    for (Image<std::uint16_t>* counts : {&stages.visible, &stages.observed}) {
      for (int u{begin}; u < end; ++u) {
        (*counts)(u, d) = static_cast<std::uint16_t>(((*counts)(u, d) + ray_parts / 2) / ray_parts);
      }
    }
  }
}

void count_columns(const Matches& matches, const UDisparityTables& tables, int begin, int end, UDisparitySpace& space,
                   StageImages& stages) {
  const int disparities{stages.occupancy.height()};
  const bool road_rays{tables.config.road_rays == RoadRays::visible};
  const bool is_weighted{tables.config.confidence_weights};
  for (int d{0}; d < disparities; ++d) {
    std::fill(stages.observed.row(d) + begin, stages.observed.row(d) + end, std::uint16_t{0});
    std::fill(space.road_pixels.row(d) + begin, space.road_pixels.row(d) + end, std::uint16_t{0});
    std::fill(space.visible_steps.row(d) + begin, space.visible_steps.row(d) + end, std::int16_t{0});
  }
  std::fill(space.visible_steps.row(disparities) + begin, space.visible_steps.row(disparities) + end, std::int16_t{0});
  for (int v{0}; v < matches.road.height(); ++v) {
    const BinRange bins{space.bins_of_row[static_cast<std::size_t>(v)]};
    for (int u{begin}; u < end; ++u) {
      const int obstacle{bin_of(matches.obstacle(u, v))};
      const int road{bin_of(matches.road(u, v))};
      const int weight{is_weighted ? ray_weight(matches.confidence(u, v)) : 1};
      if (obstacle > 0) {
        add_ray(obstacle, bins, u, weight, space.visible_steps);
        if (obstacle >= bins.first && obstacle <= bins.last) {
          stages.observed(u, obstacle) = static_cast<std::uint16_t>(stages.observed(u, obstacle) + weight);
        }
      }
      if (road > 0) {
        ++space.road_pixels(u, road);
        if (road_rays) add_ray(road, bins, u, weight, space.visible_steps);
      }
    }
  }
  for (int u{begin}; u < end; ++u) {
    stages.visible(u, 0) = static_cast<std::uint16_t>(space.visible_steps(u, 0));
  }
  for (int d{1}; d < disparities; ++d) {
    for (int u{begin}; u < end; ++u) {
      stages.visible(u, d) = static_cast<std::uint16_t>(stages.visible(u, d - 1) + space.visible_steps(u, d));
    }
  }
  if (is_weighted) round_counts(begin, end, stages);
}

void infer_row(const UDisparityTables& tables, View<const std::uint16_t> road_pixels, int d, StageImages& stages) {
  const UDisparityConfig& config{tables.config};
  const float false_positive{static_cast<float>(config.false_positive)};
  const float false_negative{static_cast<float>(config.false_negative)};
  const int possible{stages.possible[static_cast<std::size_t>(d)]};
  const int first_sighted{config.left_border ? d + tables.half_window : 0};
  for (int u{0}; u < stages.occupancy.width(); ++u) {
    const int visible{stages.visible(u, d)};
    const float visibility{visibility_of(visible, possible)};
    const float miss{tables.miss[static_cast<std::size_t>(pair_index(visible, stages.observed(u, d)))]};
    const float road{tables.road_factor[static_cast<std::size_t>(road_cells_around(road_pixels, u, d))] * miss};
    const float obstacle{obstacle_probability(visibility, 1 - miss, false_positive, false_negative)};
    stages.visibility(u, d) = visibility;
    stages.obstacle_confidence(u, d) = 1 - miss;
    stages.road_confidence(u, d) = road;
    stages.occupancy(u, d) =
        d == 0 || u < first_sighted ? 0.5f : occupancy_probability(obstacle, road, false_positive, false_negative);
  }
}

void smooth_along_columns(const std::vector<float>& weights, const float* in, int width, float* out) {
  const int reach{static_cast<int>(weights.size()) / 2};
  std::fill(out, out + width, 0.0f);
  for (int k{-reach}; k <= reach; ++k) {
    const float weight{weights[static_cast<std::size_t>(k + reach)]};
    const int inner_begin{std::clamp(-k, 0, width)};
    const int inner_end{std::clamp(width - k, inner_begin, width)};
    for (int u{0}; u < inner_begin; ++u) out[u] += weight * in[0];
    for (int u{inner_begin}; u < inner_end; ++u) out[u] += weight * in[u + k];
    for (int u{inner_end}; u < width; ++u) out[u] += weight * in[width - 1];
  }
}

void smooth_along_disparity(const std::vector<float>& weights, const Image<float>& in, int d, float* out) {
  const int reach{static_cast<int>(weights.size()) / 2};
  std::fill(out, out + in.width(), 0.0f);
  for (int k{-reach}; k <= reach; ++k) {
    const float weight{weights[static_cast<std::size_t>(k + reach)]};
    const float* row{in.row(std::clamp(d + k, 1, in.height() - 1))};
    for (int u{0}; u < in.width(); ++u) out[u] += weight * row[u];
  }
}

}  // namespace

void count(Cpu& cpu, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityTables& tables,
           UDisparitySpace& space, StageImages& stages) {
  const int width{matches.road.width()};
  const int disparities{stages.occupancy.height()};
  find_bins_of_rows(rig, ground, tables, disparities, space, stages.possible);
  cpu.for_ranges(width, columns_grain,
                 [&](int begin, int end) { count_columns(matches, tables, begin, end, space, stages); });
  cpu.for_ranges(disparities, bins_grain, [&](int begin, int end) {
    for (int d{begin}; d < end; ++d) {
      infer_row(tables, space.road_pixels.view(), d, stages);
      smooth_along_columns(tables.weights_column, stages.occupancy.row(d), width, space.smooth_once.row(d));
    }
  });
  cpu.for_ranges(disparities, bins_grain, [&](int begin, int end) {
    for (int d{begin}; d < end; ++d) {
      if (d == 0) {
        std::fill(stages.occupancy_smooth.row(0), stages.occupancy_smooth.row(0) + width, 0.5f);
      } else {
        smooth_along_disparity(tables.weights_disparity, space.smooth_once, d, stages.occupancy_smooth.row(d));
      }
    }
  });
}

}  // namespace stereogrid
