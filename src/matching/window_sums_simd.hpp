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

// out[u] = column(u) + … + column(u + size − 1) for u < width, `size` odd. Sums of 2, 4, 8 … columns are doubled in
// `powers`, and those of the binary digits of `size` are added. `columns(u)` loads the columns from u on as a vector of
// D, for u up to width + size and a vector. `out` and `powers` have room for as many.
template <class D, class Columns>
void window_sums(D d, const Columns& columns, int width, int size, hn::TFromD<D>* powers, hn::TFromD<D>* out) {
  const int lanes{static_cast<int>(hn::Lanes(d))};
  const int length{width + size};
  for (int u{0}; u < length; u += lanes) {
    const auto one = columns(u);
    hn::StoreU(one, d, out + u);
    hn::StoreU(hn::Add(one, columns(u + 1)), d, powers + u);
  }
  int summed{1};
  for (int power{2}; power <= size; power *= 2) {
    const bool is_part{(size & power) != 0};
    const bool goes_on{2 * power <= size};
    for (int u{0}; u < length; u += lanes) {
      if (is_part) hn::StoreU(hn::Add(hn::LoadU(d, out + u), hn::LoadU(d, powers + u + summed)), d, out + u);
    }
    for (int u{0}; goes_on && u < length; u += lanes) {
      hn::StoreU(hn::Add(hn::LoadU(d, powers + u), hn::LoadU(d, powers + u + power)), d, powers + u);
    }
    if (is_part) summed += power;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
