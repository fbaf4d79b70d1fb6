// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "u_disparity/fine_counts.hpp"

#include <algorithm>

#include "u_disparity/model.hpp"

namespace stereogrid {
namespace {

// A ray that arrives at a place goes on to the end of its row's bins.
template <class Changes>
void arrive(std::vector<Changes>& changes, BinRange bins, std::size_t column, int place, int sign) {
  const int before{place >= 0 ? place / bin_parts : (place - bin_parts + 1) / bin_parts};
  const int behind_parts{place - before * bin_parts};
  const int begins[]{std::max(before, bins.first), std::max(before + 1, bins.first)};
  const int parts[]{bin_parts - behind_parts, behind_parts};
  for (int i{0}; i < 2; ++i) {
    if (begins[i] > bins.last) continue;
    changes[static_cast<std::size_t>(begins[i])][column] += sign * parts[i];
    changes[static_cast<std::size_t>(bins.last) + 1][column] -= sign * parts[i];
  }
}

void mark_road(int place, int bins_per_px, int u, Image<std::uint8_t>& has_road) {
  const int reach{bins_per_px * bin_parts / 2};
  const int first{std::max((place - reach + bin_parts - 1) / bin_parts, 1)};
  const int last{std::min((place + reach) / bin_parts, has_road.height() - 1)};
  for (int k{first}; k <= last; ++k) has_road(u, k) = 1;
}

}  // namespace

FineCounts::FineCounts(int bins)
    : visible_(static_cast<std::size_t>(bins) + 1), observed_(static_cast<std::size_t>(bins) + 1) {}

void FineCounts::add_pixel(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, int u, int v,
                           int column) {
  const int per_px{config.bins_per_px};
  const auto at = static_cast<std::size_t>(column);
  const BinRange bins{rows.bins(u)[v]};
  const int obstacle{place_of_disparity(matches.obstacle(u, v), per_px)};
  if (!is_no_place(obstacle)) {
    // in the bins of its row that it is high enough for
    const BinRange high{rows.upright_bins(u)[v]};
    const BinRange upright{std::max(high.first, bins.first), std::min(high.last, bins.last)};
    arrive(visible_, bins, at, support_begin(obstacle, per_px), 1);
    arrive(observed_, upright, at, support_begin(obstacle, per_px), 1);
    arrive(observed_, upright, at, support_end(obstacle, per_px), -1);
  }
  const int road{place_of_disparity(matches.road(u, v), per_px)};
  if (config.road_rays == RoadRays::visible && !is_no_place(road)) {
    arrive(visible_, bins, at, support_begin(road, per_px), 1);
  }
}

void FineCounts::total(ColumnRange range, StageImages& stages) {
  Changes visible{};
  Changes observed{};
  for (int k{0}; k < stages.visible.height(); ++k) {
    for (int u{range.begin}; u < range.end; ++u) {
      const auto column = static_cast<std::size_t>(u - range.begin);
      visible[column] += visible_[static_cast<std::size_t>(k)][column];
      observed[column] += observed_[static_cast<std::size_t>(k)][column];
      stages.visible(u, k) = static_cast<std::uint16_t>(whole_rays(visible[column]));
      stages.observed(u, k) = static_cast<std::uint16_t>(whole_rays(observed[column]));
    }
  }
}

void FineCounts::count(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, ColumnRange range,
                       StageImages& stages, Image<std::uint8_t>& has_road) {
  std::fill(visible_.begin(), visible_.end(), Changes{});
  std::fill(observed_.begin(), observed_.end(), Changes{});
  for (int k{0}; k < has_road.height(); ++k) {
    std::fill(has_road.row(k) + range.begin, has_road.row(k) + range.end, std::uint8_t{0});
  }
  for (int v{0}; v < matches.road.height(); ++v) {
    for (int u{range.begin}; u < range.end; ++u) {
      add_pixel(matches, rows, config, u, v, u - range.begin);
      const int road{place_of_disparity(matches.road(u, v), config.bins_per_px)};
      if (!is_no_place(road)) mark_road(road, config.bins_per_px, u, has_road);
    }
  }
  total(range, stages);
}

}  // namespace stereogrid
