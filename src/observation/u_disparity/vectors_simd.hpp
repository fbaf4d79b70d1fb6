// SPDX-License-Identifier: Apache-2.0
// Vectors over a row whose length is no multiple of theirs. Included once per instruction set; the guard works per
// target.
#if defined(STEREOGRID_VECTORS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_VECTORS_SIMD
#undef STEREOGRID_VECTORS_SIMD
#else
#define STEREOGRID_VECTORS_SIMD
#endif

#include <algorithm>
#include <cstddef>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

struct Whole {};  // number of elements: all of the vector

// Calls work(u, n) for the vectors of [0, width); n: Whole, or the number of elements that are left for the last one.
template <class D, class Work>
HWY_INLINE void for_vectors(D d, int width, const Work& work) {
  const int lanes{static_cast<int>(hn::Lanes(d))};
  int u{0};
  for (; u + lanes <= width; u += lanes) work(u, Whole{});
  if (u < width) work(u, static_cast<std::size_t>(width - u));
}

template <class D>
HWY_INLINE hn::VFromD<D> load(D d, const hn::TFromD<D>* from, Whole) {
  return hn::LoadU(d, from);
}
// The last elements of a row go through a whole vector in memory, 0 behind them.
template <class D>
HWY_INLINE hn::VFromD<D> load(D d, const hn::TFromD<D>* from, std::size_t n) {
  hn::TFromD<D> whole[hn::MaxLanes(D{})]{};
  std::copy_n(from, n, whole);
  return hn::LoadU(d, whole);
}

template <class V, class D>
HWY_INLINE void store(V v, D d, hn::TFromD<D>* to, Whole) {
  hn::StoreU(v, d, to);
}
template <class V, class D>
HWY_INLINE void store(V v, D d, hn::TFromD<D>* to, std::size_t n) {
  hn::TFromD<D> whole[hn::MaxLanes(D{})];
  hn::StoreU(v, d, whole);
  std::copy_n(whole, n, to);
}

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
