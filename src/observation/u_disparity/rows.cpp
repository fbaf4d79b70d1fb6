// SPDX-License-Identifier: Apache-2.0
#include "observation/u_disparity/rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "observation/u_disparity/simd.hpp"
#include "observation/u_disparity/u_disparity.hpp"

namespace stereogrid {
namespace {

// For one row the bins that it is possible for are an interval, because both ends of S_P(d) move monotonously with d.
void find_bins(const std::vector<RowRange>& rows, int margin, std::vector<BinRange>& bins_of_row) {
  const int disparities{static_cast<int>(rows.size())};
  const int end{static_cast<int>(bins_of_row.size())};
  std::fill(bins_of_row.begin(), bins_of_row.end(), BinRange{disparities, -1});
  for (int d{0}; d < disparities; ++d) {
    const RowRange& range{rows[static_cast<std::size_t>(d)]};
    const int last{std::min(range.last + margin, end - 1)};
    for (int row{std::max(range.first + margin, 0)}; row <= last; ++row) {
      BinRange& bins{bins_of_row[static_cast<std::size_t>(row)]};
      bins.first = std::min(bins.first, d);
      bins.last = d;
    }
  }
}

}  // namespace

RowRange rows_between(const Rig& rig, const Ground& ground, double lower_m, double upper_m, double d) {
  return rows_between(RowsByHeight{rig, ground}, lower_m, upper_m, d);
}

RowRange possible_rows(const Rig& rig, const Ground& ground, double obstacle_height_m, double d, int image_height) {
  const RowRange rows{rows_between(rig, ground, 0, obstacle_height_m, d)};
  return {std::max(rows.first, 0), std::min(rows.last, image_height - 1)};
}

BinRows::BinRows(int width, int image_height, int bins)
    : height{image_height},
      margin{largest_shift(width)},
      shift(static_cast<std::size_t>(width)),
      rows(static_cast<std::size_t>(bins)),
      upright_rows(static_cast<std::size_t>(bins)),
      bins_of_row(static_cast<std::size_t>(image_height + 2 * margin)),
      upright_bins_of_row(static_cast<std::size_t>(image_height + 2 * margin)) {
  blocks.reserve(shift.size());
}

void BinRows::cut(int widest) {
  blocks.clear();
  const int width{static_cast<int>(shift.size())};
  for (int begin{0}, end{0}; begin < width; begin = end) {
    const auto shift_here = shift[static_cast<std::size_t>(begin)];
    while (end < width && end - begin < widest && shift[static_cast<std::size_t>(end)] == shift_here) ++end;
    blocks.push_back({begin, end});
  }
}

void BinRows::place(const Rig& rig, const Ground& ground, const UDisparityConfig& config) {
  const double slope{config.follow_roll ? -std::tan(ground.roll_rad) : 0.0};
  for (std::size_t u{0}; u < shift.size(); ++u) {
    shift[u] = row_shift(slope, static_cast<double>(u) - rig.cx_px, margin);
  }
  const RowsByHeight by_height{rig, ground};
  for (int d{0}; d < static_cast<int>(rows.size()); ++d) {
    const auto i{static_cast<std::size_t>(d)};
    const double disparity{static_cast<double>(d)};
    rows[i] = rows_between(by_height, 0, config.obstacle_height_m, disparity);
    upright_rows[i] = rows_between(by_height, config.obstacle_min_height_m, config.obstacle_height_m, disparity);
  }
  find_bins(rows, margin, bins_of_row);
  find_bins(upright_rows, margin, upright_bins_of_row);
}

UDisparityTables::UDisparityTables(const BinConfig& parameters, int image_height, int window_px)
    : config{parameters},
      half_window{window_px / 2},
      miss(static_cast<std::size_t>(pair_index(image_height + 1, 0))),
      weights_column{gaussian_weights(parameters.sigma_column)},
      weights_disparity{gaussian_weights(parameters.sigma_disparity)} {
  for (int visible{0}; visible <= image_height; ++visible) {
    for (int observed{0}; observed <= visible; ++observed) {
      miss[static_cast<std::size_t>(pair_index(visible, observed))] = miss_of(config, visible, observed);
    }
  }
  for (std::size_t cells{0}; cells < road_factor.size(); ++cells) {
    road_factor[cells] = static_cast<float>(std::exp(-(1 - static_cast<double>(cells) / 9) / config.tau_road));
  }
}

float miss_of(const BinConfig& config, int visible, int observed) {
  if (visible == 0) return 1;
  const double share{static_cast<double>(observed) / (visible + config.small_count_guard)};
  return static_cast<float>(std::exp(-share / config.tau_obstacle));
}

std::vector<float> gaussian_weights(double sigma) {
  if (sigma <= 0) return {1.0f};
  const auto below = [&](double x) { return 0.5 * std::erfc(-x / (sigma * std::numbers::sqrt2)); };
  const int reach{static_cast<int>(std::ceil(3 * sigma))};
  std::vector<double> weights;
  double sum{0};
  for (int k{-reach}; k <= reach; ++k) {
    weights.push_back(below(k + 0.5) - below(k - 0.5));
    sum += weights.back();
  }
  std::vector<float> normalised;
  for (const double weight : weights) normalised.push_back(static_cast<float>(weight / sum));
  return normalised;
}

UDisparityWorkspace::UDisparityWorkspace(int width, int height, int bins, int threads)
    : rows{width, height, bins},
      counts(static_cast<std::size_t>(threads),
             std::vector<std::uint16_t>(static_cast<std::size_t>(bins + 1) * pixel_kinds * block_columns)),
      has_road{width, bins},
      road_columns{width, bins + 1},
      smooth_once{width, bins} {}

}  // namespace stereogrid
