// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "u_disparity/infer_simd.hpp"
#include "u_disparity/model.hpp"
#include "u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

constexpr int block{64};  // columns whose counts stay in the first cache
constexpr int bins_grain{8};
constexpr std::size_t taps_max{2 * 60 + 1};  // of sigma_column 20

// A pixel that ends at bin `end` is a ray through every bin from there on: one step up, one step down.
void add_ray(int end, BinRange bins, int u, int weight, Image<std::int16_t>& steps) {
  const int from{std::max(end, bins.first)};
  if (from > bins.last) return;
  steps(u, from) = static_cast<std::int16_t>(steps(u, from) + weight);
  steps(u, bins.last + 1) = static_cast<std::int16_t>(steps(u, bins.last + 1) - weight);
}

// The obstacle and road pixels of columns begin … end − 1.
void count_pixels(const Matches& matches, const UDisparityConfig& config, int begin, int end, UDisparitySpace& space,
                  Image<std::uint16_t>& observed) {
  std::array<std::int16_t, block> ends;
  const bool road_rays{config.road_rays == RoadRays::visible};
  for (int v{0}; v < matches.road.height(); ++v) {
    find_ends(matches.obstacle.row(v) + begin, matches.road.row(v) + begin, end - begin, ends.data());
    for (int u{begin}; u < end; ++u) {
      const int at{ends[static_cast<std::size_t>(u - begin)]};
      if (at == 0) continue;
      const int weight{config.confidence_weights ? ray_weight(matches.confidence(u, v)) : 1};
      if (at < 0) {
        if (-at < space.has_road.height()) space.has_road(u, -at) = 1;
        if (road_rays) add_ray(-at, space.rows.bins(u, v), u, weight, space.visible_steps);
        continue;
      }
      add_ray(at, space.rows.bins(u, v), u, weight, space.visible_steps);
      const BinRange upright{space.rows.upright_bins(u, v)};
      if (at >= upright.first && at <= upright.last) {
        observed(u, at) = static_cast<std::uint16_t>(observed(u, at) + weight);
      }
    }
  }
}

// Parts of rays to rays.
void round_counts(int begin, int end, Image<std::uint16_t>& counts) {
  for (int d{0}; d < counts.height(); ++d) {
    std::uint16_t* row{counts.row(d)};
    for (int u{begin}; u < end; ++u) row[u] = static_cast<std::uint16_t>((row[u] + ray_parts / 2) / ray_parts);
  }
}

// N_V, N_O and the road's bins in columns begin … end − 1.
void count_block(const Matches& matches, const UDisparityConfig& config, int begin, int end, UDisparitySpace& space,
                 StageImages& stages) {
  const int disparities{stages.occupancy.height()};
  for (int d{0}; d < disparities; ++d) {
    std::fill(stages.observed.row(d) + begin, stages.observed.row(d) + end, std::uint16_t{0});
    std::fill(space.has_road.row(d) + begin, space.has_road.row(d) + end, std::uint8_t{0});
    std::fill(space.visible_steps.row(d) + begin, space.visible_steps.row(d) + end, std::int16_t{0});
  }
  std::fill(space.visible_steps.row(disparities) + begin, space.visible_steps.row(disparities) + end, std::int16_t{0});
  count_pixels(matches, config, begin, end, space, stages.observed);
  std::array<std::uint16_t, block> sum{};
  for (int d{0}; d < disparities; ++d) {
    const std::int16_t* steps{space.visible_steps.row(d)};
    std::uint16_t* visible{stages.visible.row(d)};
    for (int u{begin}; u < end; ++u) {
      std::uint16_t& rays{sum[static_cast<std::size_t>(u - begin)]};
      rays = static_cast<std::uint16_t>(rays + steps[u]);
      visible[u] = rays;
    }
  }
  if (!config.confidence_weights) return;
  round_counts(begin, end, stages.visible);
  round_counts(begin, end, stages.observed);
}

// Of the three columns around each; bin 0 and the bins behind the last count as empty.
void sum_road_columns(UDisparitySpace& space, int d) {
  const int width{space.has_road.width()};
  std::uint8_t* sums{space.road_columns.row(d)};
  if (d == 0 || d >= space.has_road.height()) {
    std::fill(sums, sums + width, std::uint8_t{0});
    return;
  }
  const std::uint8_t* row{space.has_road.row(d)};
  for (int u{1}; u < width - 1; ++u) sums[u] = static_cast<std::uint8_t>(row[u - 1] + row[u] + row[u + 1]);
  sums[0] = static_cast<std::uint8_t>(row[0] + (width > 1 ? row[1] : 0));
  if (width > 1) sums[width - 1] = static_cast<std::uint8_t>(row[width - 2] + row[width - 1]);
}

void infer_row(const UDisparityTables& tables, const UDisparitySpace& space, int d, StageImages& stages) {
  const UDisparityConfig& config{tables.config};
  const RowRange rows{space.rows.rows[static_cast<std::size_t>(d)]};
  int first_sighted{config.left_border ? d + tables.half_window : 0};
  if (d == 0) first_sighted = std::numeric_limits<int>::max();
  infer_bins(
      {stages.visible.row(d), stages.observed.row(d), space.road_columns.row(std::max(d - 1, 0)),
       space.road_columns.row(d), space.road_columns.row(d + 1), space.rows.shift.data(), rows.first, rows.last,
       space.rows.height, tables.miss.data(), tables.road_factor.data(), static_cast<float>(config.false_positive),
       static_cast<float>(config.false_negative), first_sighted, stages.visibility.row(d),
       stages.obstacle_confidence.row(d), stages.road_confidence.row(d), stages.occupancy.row(d)},
      stages.occupancy.width());
}

// One output column with the borders repeated.
float smooth_at(const std::vector<float>& weights, const float* in, int width, int u) {
  const int reach{static_cast<int>(weights.size()) / 2};
  float sum{0};
  for (int k{-reach}; k <= reach; ++k) {
    sum += weights[static_cast<std::size_t>(k + reach)] * in[std::clamp(u + k, 0, width - 1)];
  }
  return sum;
}

void smooth_along_columns(const std::vector<float>& weights, const float* in, int width, float* out) {
  const int taps{static_cast<int>(weights.size())};
  const int reach{taps / 2};
  const int inner{std::max(width - 2 * reach, 0)};
  std::array<const float*, taps_max> shifted;
  for (int k{0}; k < taps; ++k) shifted[static_cast<std::size_t>(k)] = in + k;
  weigh_rows(shifted.data(), weights.data(), taps, inner, out + reach);
  for (int u{0}; u < std::min(reach, width); ++u) out[u] = smooth_at(weights, in, width, u);
  for (int u{std::min(reach, width) + inner}; u < width; ++u) out[u] = smooth_at(weights, in, width, u);
}

void smooth_along_disparity(const std::vector<float>& weights, const Image<float>& in, int d, float* out) {
  const int taps{static_cast<int>(weights.size())};
  std::array<const float*, taps_max> rows;
  for (int k{0}; k < taps; ++k) {
    rows[static_cast<std::size_t>(k)] = in.row(std::clamp(d + k - taps / 2, 1, in.height() - 1));
  }
  weigh_rows(rows.data(), weights.data(), taps, in.width(), out);
}

}  // namespace

void count(Cpu& cpu, const Matches& matches, const Rig& rig, const Ground& ground, const UDisparityTables& tables,
           UDisparitySpace& space, StageImages& stages) {
  const int width{matches.road.width()};
  const int disparities{stages.occupancy.height()};
  space.rows.place(rig, ground, tables.config);
  for (int d{0}; d < disparities; ++d) {
    const RowRange rows{space.rows.rows[static_cast<std::size_t>(d)]};
    stages.possible[static_cast<std::size_t>(d)] = possible_in_column(rows.first, rows.last, 0, space.rows.height);
  }
  cpu.for_ranges((width + block - 1) / block, 1, [&](int begin, int end) {
    for (int b{begin}; b < end; ++b) {
      count_block(matches, tables.config, b * block, std::min((b + 1) * block, width), space, stages);
    }
  });
  cpu.for_ranges(disparities + 1, bins_grain, [&](int begin, int end) {
    for (int d{begin}; d < end; ++d) sum_road_columns(space, d);
  });
  cpu.for_ranges(disparities, bins_grain, [&](int begin, int end) {
    for (int d{begin}; d < end; ++d) {
      infer_row(tables, space, d, stages);
      smooth_along_columns(tables.weights_column, stages.occupancy.row(d), width, space.smooth_once.row(d));
    }
  });
  std::fill(stages.occupancy_smooth.row(0), stages.occupancy_smooth.row(0) + width, 0.5f);
  cpu.for_ranges(disparities - 1, bins_grain, [&](int begin, int end) {
    for (int d{begin + 1}; d < end + 1; ++d) {
      smooth_along_disparity(tables.weights_disparity, space.smooth_once, d, stages.occupancy_smooth.row(d));
    }
  });
}

}  // namespace stereogrid
