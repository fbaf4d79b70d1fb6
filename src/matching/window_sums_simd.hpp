// SPDX-License-Identifier: Apache-2.0
//
// Sums over a window's columns with vectors along the row. Included once per instruction set; the guard works per
// target.
#if defined(STEREOGRID_WINDOW_SUMS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_WINDOW_SUMS_SIMD
#undef STEREOGRID_WINDOW_SUMS_SIMD
#else
#define STEREOGRID_WINDOW_SUMS_SIMD
#endif

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Sum that saturates where it has 8 or 16 bits.
template <class V>
HWY_INLINE V saturated_sum(V a, V b) {
  if constexpr (sizeof(hn::TFromV<V>) > 2) {
    return hn::Add(a, b);
  } else {
    return hn::SaturatedAdd(a, b);
  }
}

// Sums of four columns, for window_sums.
template <class D, class Columns>
HWY_INLINE void sums_of_fours(D d, const Columns& columns, int width, int size, hn::TFromD<D>* fours) {
#pragma GCC unroll 2
  for (int u{0}; u < width + size; u += static_cast<int>(hn::MaxLanes(D{}))) {
    const auto left = saturated_sum(columns(u), columns(u + 1));
    hn::StoreU(saturated_sum(left, saturated_sum(columns(u + 2), columns(u + 3))), d, fours + u);
  }
}

// store(column(u) + … + column(u + size − 1), u) for u < width, `size` odd. `columns(u)` loads the columns from u on as
// a vector of D, for u up to width + size and 128 bytes; `fours` are their sums, with room for as many. The last 128
// bytes that are stored may exceed the width.
template <class D, class Columns, class Store>
HWY_INLINE void window_sums(D d, const Columns& columns, int width, int size, const hn::TFromD<D>* fours,
                            const Store& store) {
  constexpr int lanes{static_cast<int>(hn::MaxLanes(D{}))};
  constexpr int vectors{128 / static_cast<int>(sizeof(hn::TFromD<D>)) / lanes};
  const int single{size % 4};
  for (int u{0}; u < width; u += vectors * lanes) {
    hn::Vec<D> sums[vectors];
    for (int i{0}; i < vectors; ++i) sums[i] = columns(u + i * lanes);
    const auto add = [&](const auto& of, int from, int end, int step) {
      for (int at{from}; at < end; at += step) {
        for (int i{0}; i < vectors; ++i) sums[i] = saturated_sum(sums[i], of(at + i * lanes));
      }
    };
    add(columns, u + 1, u + single, 1);
    add([&](int at) { return hn::LoadU(d, fours + at); }, u + single, u + size, 4);
    for (int i{0}; i < vectors; ++i) store(sums[i], u + i * lanes);
  }
}

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
