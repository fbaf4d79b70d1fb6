// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "observation/u_disparity/rows.hpp"

#include <algorithm>
#include <cmath>

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

}  // namespace stereogrid
