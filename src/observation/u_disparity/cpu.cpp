// SPDX-License-Identifier: Apache-2.0
#include "backend/cpu.hpp"

#include <array>
#include <limits>

#include "observation/u_disparity/model.hpp"
#include "observation/u_disparity/simd.hpp"
#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

constexpr int bins_grain{8};
constexpr std::size_t taps_max{2 * 60 + 1};  // taps for sigma_column 20

// N_V, N_O and the road's bins in columns begin … end − 1, which have one shift.
void count_block(const Matches& matches, const BinConfig& config, ColumnRange columns,
                 std::vector<std::uint16_t>& counts, UDisparityWorkspace& space, StageImages& stages) {
  const int begin{columns.begin};
  const int width{columns.end - begin};
  const int disparities{stages.occupancy.height()};
  count_pixels(
      {matches.obstacle.data() + begin, matches.road.data() + begin, matches.road.width(), width, matches.road.height(),
       disparities, config.road_rays == RoadRays::visible, space.rows.bins(begin), space.rows.upright_bins(begin)},
      counts.data());
  total_block({stages.visible.data() + begin, stages.observed.data() + begin, space.has_road.data() + begin,
               matches.road.width(), width, disparities},
              counts.data());
}

void count_pixel_bins(Cpu& cpu, const Matches& matches, const BinConfig& config, UDisparityWorkspace& space,
                      StageImages& stages) {
  space.rows.cut(block_columns);
  const int parts{static_cast<int>(space.counts.size())};
  cpu.for_parts(static_cast<int>(space.rows.blocks.size()), parts, [&](int part, int begin, int end) {
    std::vector<std::uint16_t>& counts{space.counts[static_cast<std::size_t>(part)]};
    for (int b{begin}; b < end; ++b) {
      count_block(matches, config, space.rows.blocks[static_cast<std::size_t>(b)], counts, space, stages);
    }
  });
}

// Sums over the three columns around each; bin 0 and bins behind the last count as empty.
void sum_road_columns(UDisparityWorkspace& space, int d) {
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

void infer_row(const UDisparityTables& tables, const UDisparityWorkspace& space, int d, StageImages& stages) {
  const BinConfig& config{tables.config};
  const RowRange rows{space.rows.rows[static_cast<std::size_t>(d)]};
  const int road_before{std::max(d - 1, 0)};
  const int road_behind{std::min(d + 1, stages.occupancy.height())};
  int first_sighted{config.left_border ? d + tables.half_window : 0};
  if (d == 0) first_sighted = std::numeric_limits<int>::max();
  infer_bins(
      {stages.visible.row(d), stages.observed.row(d), space.road_columns.row(road_before), space.road_columns.row(d),
       space.road_columns.row(road_behind), space.rows.shift.data(), rows.first, rows.last, space.rows.height,
       tables.miss.data(), tables.road_factor.data(), static_cast<float>(config.false_positive),
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
           UDisparityWorkspace& space, StageImages& stages) {
  const int width{matches.road.width()};
  const int disparities{stages.occupancy.height()};
  space.rows.place(rig, ground, tables.config);
  for (int d{0}; d < disparities; ++d) {
    const RowRange rows{space.rows.rows[static_cast<std::size_t>(d)]};
    stages.possible[static_cast<std::size_t>(d)] = possible_in_column(rows.first, rows.last, 0, space.rows.height);
  }
  count_pixel_bins(cpu, matches, tables.config, space, stages);
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
