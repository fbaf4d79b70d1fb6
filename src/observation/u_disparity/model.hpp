// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "clamped_to_int.hpp"
#include "geometry/road_plane.hpp"
#include "host_device.hpp"
#include "numbers.hpp"

namespace stereogrid {

/// Rows first … last; none where first > last.
struct RowRange {
  int first;
  int last;
};

/// Bins for which a row is possible: first … last; none where first > last.
struct BinRange {
  int first;
  int last;
};

/// Rows between two heights above the road at disparity d, in the column u0; the image may end before. eq. 9.
STEREOGRID_HD inline RowRange rows_between(const RowsByHeight& rows, double lower_m, double upper_m, double d) {
  return {clamped_to_int(std::ceil(rows.row(d, upper_m))), clamped_to_int(std::floor(rows.row(d, lower_m)))};
}

/// A column's rows are shifted by at most an eighth of the image's width: roll up to 14 degrees.
STEREOGRID_HD inline int largest_shift(int width) {
  return width / 8;
}

/// By how many rows the road of roll lies lower in a column than in the column u0. `slope`: −tan(roll).
STEREOGRID_HD inline std::int32_t row_shift(double slope, double columns_from_centre, int limit) {
  return clamped_to_int(std::round(slope * columns_from_centre), limit);
}

#include "observation/u_disparity/bin_formulas.hpp"

STEREOGRID_HD inline BinConstants<float> bin_constants(float false_positive, float false_negative) {
  return {1, 0.5f, false_negative, 1 - false_positive};
}

/// Bin of a disparity; 0 is "no measurement".
STEREOGRID_HD inline int bin_of(float disparity) {
  return static_cast<int>(disparity + 0.5f);
}

/// Eq. 10 in a column whose rows of the bin are first … last before the image's ends are looked at, `shift` lower.
STEREOGRID_HD inline int possible_in_column(int first, int last, int shift, int height) {
  const int from{first + shift > 0 ? first + shift : 0};
  const int to{last + shift < height - 1 ? last + shift : height - 1};
  return to >= from ? to - from + 1 : 0;
}

/// Eq. 11: share of the possible rays that reach the bin.
STEREOGRID_HD inline float visibility_of(int visible, int possible) {
  return possible > 0 ? static_cast<float>(visible) / static_cast<float>(possible) : 0.0f;
}

/// Place of (N_V, N_O), N_O ≤ N_V, in a table over all pairs.
STEREOGRID_HD inline int pair_index(int visible, int observed) {
  return visible * (visible + 1) / 2 + observed;
}

/// Number of the nine bins around (u, d) with a road pixel (docs/method.md §5.3). Bin 0 and bins outside count as
/// empty. `has_road` is (D, W).
template <class View>
STEREOGRID_HD inline int road_cells_around(const View& has_road, int u, int d) {
  const int last_u{u + 1 < has_road.width ? u + 1 : has_road.width - 1};
  int cells{0};
  for (int dd{d - 1}; dd <= d + 1; ++dd) {
    if (dd < 1 || dd >= has_road.height) continue;
    for (int uu{u > 0 ? u - 1 : 0}; uu <= last_u; ++uu) cells += has_road(uu, dd);
  }
  return cells;
}

}  // namespace stereogrid
