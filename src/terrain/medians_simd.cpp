// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run down the rows.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "terrain/medians_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"

#include <algorithm>
#include <cstddef>

#include "geometry/relief.hpp"
#include "terrain/samples.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int half_px{sector_px / 2};
using Rows = hn::CappedTag<float, 8>;
using Columns = hn::CappedTag<float, half_px>;
using V = hn::Vec<Rows>;

// Sorts the eight numbers of each row.
HWY_INLINE void sort_columns(V (&column)[sector_px]) {
  constexpr int pairs[][2]{{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {1, 2}, {5, 6},
                           {0, 4}, {3, 7}, {1, 5}, {2, 6}, {1, 4}, {3, 6}, {2, 4}, {3, 5}, {3, 4}};
  for (const auto& [low, high] : pairs) {
    const V least{hn::Min(column[low], column[high])};
    column[high] = hn::Max(column[low], column[high]);
    column[low] = least;
  }
}

// Medians of sorted numbers: zeros come first.
HWY_INLINE V medians_of(const V (&column)[sector_px]) {
  const Rows d;
  const auto is_there = [&](int rank) HWY_ATTR { return hn::Gt(column[rank], hn::Zero(d)); };
  const V of_three{hn::IfThenElseZero(is_there(5), column[6])};  // three or four disparities
  const V of_five{hn::IfThenElse(is_there(3), column[5], of_three)};
  return hn::IfThenElse(is_there(1), column[4], of_five);
}

void FindMedians(View<const float> obstacle, View<const float> road, int at, ImageRows rows, float* medians) {
  constexpr int lanes{hn::MaxLanes(Rows{})};
  if (rows.end - rows.begin < lanes) return plain::find_medians(obstacle, road, at, rows, medians);
  for (int next{rows.begin}; next < rows.end; next += lanes) {
    const int begin{std::min(next, rows.end - lanes)};
    HWY_ALIGN float halves[2][half_px * lanes];
    const float* one{obstacle.row(begin) + at};
    const float* other{road.row(begin) + at};
    for (int i{0}; i < lanes; ++i, one += obstacle.pitch, other += road.pitch) {
      for (int k{0}; k < sector_px; k += static_cast<int>(hn::MaxLanes(Columns{}))) {
        hn::StoreU(hn::Max(hn::LoadU(Columns{}, one + k), hn::LoadU(Columns{}, other + k)), Columns{},
                   &halves[k / half_px][i * half_px + k % half_px]);
      }
    }
    V column[sector_px];
    hn::LoadInterleaved4(Rows{}, halves[0], column[0], column[1], column[2], column[3]);
    hn::LoadInterleaved4(Rows{}, halves[1], column[4], column[5], column[6], column[7]);
    sort_columns(column);
    hn::StoreU(medians_of(column), Rows{}, medians + (begin - rows.begin));
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FindMedians);

void find_medians(View<const float> obstacle, View<const float> road, int column, ImageRows rows, float* medians) {
  if (obstacle.width < sector_px) return plain::find_medians(obstacle, road, column, rows, medians);
  HWY_DYNAMIC_DISPATCH(FindMedians)(obstacle, road, column, rows, medians);
}

}  // namespace stereogrid
#endif
