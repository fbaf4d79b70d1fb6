// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// store(column(u) + … + column(u + size − 1), u) for u < width, `size` odd: the window's columns are added in fours.
// `columns(u)` loads the columns from u on as a vector of D, for u up to width + size and 128 bytes. `fours` has room
// for as many. The last 128 bytes that are stored may exceed the width.
template <class D, class Columns, class Store>
HWY_INLINE void window_sums(D d, const Columns& columns, int width, int size, hn::TFromD<D>* fours,
                            const Store& store) {
  constexpr int lanes{static_cast<int>(hn::MaxLanes(D{}))};
  constexpr int vectors{128 / static_cast<int>(sizeof(hn::TFromD<D>)) / lanes};
#pragma GCC unroll 2
  for (int u{0}; u < width + size; u += lanes) {
    const auto sum = hn::Add(hn::Add(columns(u), columns(u + 1)), hn::Add(columns(u + 2), columns(u + 3)));
    hn::StoreU(sum, d, fours + u);
  }
  const int single{size % 4};
  for (int u{0}; u < width; u += vectors * lanes) {
    hn::Vec<D> sums[vectors];
    for (int i{0}; i < vectors; ++i) sums[i] = columns(u + i * lanes);
    const auto add = [&](const auto& of, int from, int end, int step) {
      for (int at{from}; at < end; at += step) {
        for (int i{0}; i < vectors; ++i) sums[i] = hn::Add(sums[i], of(at + i * lanes));
      }
    };
    add(columns, u + 1, u + single, 1);
    add([&](int at) { return hn::LoadU(d, fours + at); }, u + single, u + size, 4);
    for (int i{0}; i < vectors; ++i) store(sums[i], u + i * lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
