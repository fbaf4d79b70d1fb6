// SPDX-License-Identifier: Apache-2.0
// Vectors over a row of any length, for work that does not care how long they are. Included once per instruction set;
// the guard works per target.
#if defined(STEREOGRID_PARTIAL_VECTORS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_PARTIAL_VECTORS_SIMD
#undef STEREOGRID_PARTIAL_VECTORS_SIMD
#else
#define STEREOGRID_PARTIAL_VECTORS_SIMD
#endif

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Calls work(d, i) for the vectors of [i, count), the last ones ever shorter, so that the rest needs no copy through
// memory.
template <class D, class Work>
HWY_INLINE void for_shrinking_vectors(D d, int i, int count, const Work& work) {
  const int lanes{static_cast<int>(hn::Lanes(d))};
  for (; i + lanes <= count; i += lanes) work(d, i);
  if constexpr (hn::MaxLanes(d) > 1) for_shrinking_vectors(hn::Half<D>{}, i, count, work);
}

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
