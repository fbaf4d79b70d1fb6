// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include "observation/rays/hidden.hpp"

#include <algorithm>

namespace stereogrid {
namespace {

constexpr int least_group_columns{8};

// Nearer, the columns of a cell change too fast to be bounded by those of others.
constexpr double nearest_m{0.5};

// More than what find_rays rounds.
constexpr double columns_margin{2};
constexpr double bins_margin{2.1};

}  // namespace

HiddenCells::HiddenCells(const RaySums<Host>& sums, const BinGeometry& geometry, const GridInVehicle& grid)
    : geometry_{geometry},
      grid_{grid},
      width_{columns_of(sums)},
      bins_{bins_of(sums)},
      group_columns_{std::max(least_group_columns, (width_ + groups_max - 1) / groups_max)} {
  for (int begin{0}, group{0}; begin < width_; begin += group_columns_, ++group) {
    const int end{std::min(begin + group_columns_, width_)};
    int& bins{empty_bins_[static_cast<std::size_t>(group)]};
    while (bins <= bins_ && sums.row(end)[bins] - sums.row(begin)[bins] < arriving_ray) ++bins;
  }
}

bool HiddenCells::is_empty_before(int end, int first_column, int last_column) const {
  for (int group{first_column / group_columns_}; group <= last_column / group_columns_; ++group) {
    if (empty_bins_[static_cast<std::size_t>(group)] < end) return false;
  }
  return true;
}

bool HiddenCells::are_hidden(int x_first, int y_first, int x_last, int y_last) const {
  const double half_m{grid_.grid.cell_size_m / 2};
  double nearest{0};
  double farthest{0};
  double leftmost{width_ + columns_margin};
  double rightmost{-columns_margin};
  for (int corner{0}; corner < 4; ++corner) {
    const Point2 at{grid_.centre(corner % 2 == 0 ? x_first : x_last, corner / 2 == 0 ? y_first : y_last)};
    nearest = corner == 0 ? at.x : std::min(nearest, at.x);
    farthest = corner == 0 ? at.x : std::max(farthest, at.x);
    if (!(at.x - half_m > nearest_m)) continue;
    leftmost = std::min(leftmost, geometry_.column(at.x, at.y + half_m));
    rightmost = std::max(rightmost, geometry_.column(at.x, at.y - half_m));
  }
  if (farthest <= 0) return true;  // find_rays: behind the camera
  if (!(nearest - half_m > nearest_m)) return false;
  const double first{std::max(leftmost - columns_margin, 0.0)};
  const double last{std::min(rightmost + columns_margin, width_ - 1.0)};
  if (!(first <= last)) return true;
  const double place{geometry_.disparity(nearest - half_m) * ray_bins_per_px + bins_margin};
  if (!(place <= bins_)) return false;
  return is_empty_before(static_cast<int>(place), static_cast<int>(first), static_cast<int>(last));
}

}  // namespace stereogrid
