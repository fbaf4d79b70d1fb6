// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "u_disparity/fine_counts.hpp"

#include <algorithm>

#include "u_disparity/model.hpp"

namespace stereogrid {
namespace {

// A ray that arrives at a place goes on to the end of its row's bins.
void arrive(std::vector<std::int32_t>& changes, BinRange bins, int place, int weight) {
  const int before{place >= 0 ? place / bin_parts : (place - bin_parts + 1) / bin_parts};
  const int behind_parts{place - before * bin_parts};
  const int begins[]{std::max(before, bins.first), std::max(before + 1, bins.first)};
  const int parts[]{bin_parts - behind_parts, behind_parts};
  for (int i{0}; i < 2; ++i) {
    if (begins[i] > bins.last) continue;
    changes[static_cast<std::size_t>(begins[i])] += weight * parts[i];
    changes[static_cast<std::size_t>(bins.last) + 1] -= weight * parts[i];
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

void FineCounts::add_pixel(const Matches& matches, const UDisparityConfig& config, int u, int v, BinRange bins,
                           BinRange upright) {
  const int per_px{config.bins_per_px};
  const int obstacle{place_of_disparity(matches.obstacle(u, v), per_px)};
  const int road{place_of_disparity(matches.road(u, v), per_px)};
  const int weight{config.confidence_weights ? ray_weight(matches.confidence(u, v)) : ray_parts};
  if (!is_no_place(obstacle)) {
    arrive(visible_, bins, support_begin(obstacle, per_px), weight);
    arrive(observed_, upright, support_begin(obstacle, per_px), weight);
    arrive(observed_, upright, support_end(obstacle, per_px), -weight);
  }
  if (config.road_rays == RoadRays::visible && !is_no_place(road)) {
    arrive(visible_, bins, support_begin(road, per_px), weight);
  }
}

void FineCounts::count(const Matches& matches, const BinRows& rows, const UDisparityConfig& config, int u,
                       StageImages& stages, Image<std::uint8_t>& has_road) {
  std::fill(visible_.begin(), visible_.end(), 0);
  std::fill(observed_.begin(), observed_.end(), 0);
  const int bins{stages.visible.height()};
  for (int k{0}; k < bins; ++k) has_road(u, k) = 0;
  for (int v{0}; v < matches.road.height(); ++v) {
    // in the bins of its row, and of them in those that it is high enough for
    const BinRange possible{rows.bins(u)[v]};
    BinRange upright{rows.upright_bins(u)[v]};
    upright = {std::max(upright.first, possible.first), std::min(upright.last, possible.last)};
    add_pixel(matches, config, u, v, possible, upright);
    const int road{place_of_disparity(matches.road(u, v), config.bins_per_px)};
    if (!is_no_place(road)) mark_road(road, config.bins_per_px, u, has_road);
  }
  int visible{0};
  int observed{0};
  for (int k{0}; k < bins; ++k) {
    visible += visible_[static_cast<std::size_t>(k)];
    observed += observed_[static_cast<std::size_t>(k)];
    stages.visible(u, k) = static_cast<std::uint16_t>(whole_rays(visible));
    stages.observed(u, k) = static_cast<std::uint16_t>(whole_rays(observed));
  }
}

}  // namespace stereogrid
