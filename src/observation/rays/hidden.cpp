// SPDX-License-Identifier: Apache-2.0
#include "observation/rays/rays.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "images/patch.hpp"

namespace stereogrid {
namespace {

constexpr int least_group_columns{8};

// Nearer, the columns of a cell change too fast to be bounded by those of others.
constexpr double nearest_m{0.5};

// More than what find_rays rounds.
constexpr double columns_margin{2};
constexpr double bins_margin{2.1};

/// Second differences of disparities are counted in parts of a pixel.
constexpr int parts_per_px{64};

/// Pixels of one surface differ by less, px.
constexpr float same_surface_px{1.5f};

/// Blur relative to the median magnitude of second differences. Three standard deviations of independent noise are
/// 1.8 medians; windows that overlap hide a part of it. With 2.1 the lidar drives keep the widest blur.
constexpr float blur_per_difference{2.1f};

/// Chosen on B-crossing: below it walls of one cell are missed.
constexpr float narrowest_blur_px{0.35f};
constexpr int least_differences{100};

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

float blur_of(const Matches& matches, int window_px) {
  const MatchLattice lattice{matches.obstacle.width(), matches.obstacle.height()};
  const int apart{std::max(window_px / 9, 1)};  // windows of neighbours overlap by a third
  std::array<int, static_cast<std::size_t>(3 * same_surface_px * parts_per_px)> counts{};
  int total{0};
  for (int j{0}; j < lattice.down; ++j) {
    const float* const row{matches.obstacle.row(MatchLattice::first_v + j * MatchLattice::step_v)};
    const auto at = [&](int i) { return row[MatchLattice::first_u + i * MatchLattice::step_u]; };
    for (int i{apart}; i + apart < lattice.across; ++i) {
      const float before{at(i - apart)};
      const float here{at(i)};
      const float after{at(i + apart)};
      if (!(before > 0 && here > 0 && after > 0) || std::abs(before - after) >= same_surface_px) continue;
      const auto part = static_cast<std::size_t>(std::abs(before - 2 * here + after) * parts_per_px);
      ++counts[std::min(part, counts.size() - 1)];
      ++total;
    }
  }
  if (total < least_differences) return widest_blur_px;
  int median{0};
  for (int below{counts[0]}; 2 * below < total; below += counts[static_cast<std::size_t>(median)]) ++median;
  return std::clamp(blur_per_difference * (static_cast<float>(median) + 0.5f) / parts_per_px, narrowest_blur_px,
                    widest_blur_px);
}

float blur_of(double sigma_px) {
  return std::clamp(3 * static_cast<float>(sigma_px), narrowest_blur_px, widest_blur_px);
}

}  // namespace stereogrid
