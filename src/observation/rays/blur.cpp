// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "images/patch.hpp"
#include "observation/rays/rays.hpp"

namespace stereogrid {
namespace {

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
