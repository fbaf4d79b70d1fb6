// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/checks/surfaces_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                                 // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/checks/simd.hpp"

#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

template <class D, class Mask>
HWY_INLINE std::uint64_t bits_of(D d, Mask pixels) {
  std::uint8_t bytes[8]{};
  hn::StoreMaskBits(d, pixels, bytes);
  return bytes[0] | static_cast<std::uint64_t>(bytes[1]) << 8;
}

void FlagSurfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                  SurfaceBits& bits) {
  constexpr int word{64};
  const hn::CappedTag<float, 16> df;
  const int lanes{static_cast<int>(hn::Lanes(df))};
  const auto zero = hn::Zero(df);
  int u{0};
  for (; u + lanes <= width; u += lanes) {
    hn::StoreU(hn::Sub(hn::LoadU(df, obstacle + u), hn::LoadU(df, road + u)), df, labelled + u);
  }
  for (; u < width; ++u) labelled[u] = obstacle[u] - road[u];
  for (int begin{0}; begin <= width; begin += word) {
    std::uint64_t measured{0};
    std::uint64_t left{0};
    std::uint64_t up{0};
    for (int i{0}; i < word; i += lanes) {
      const float* const at{labelled + begin + i};
      const auto here = hn::LoadU(df, at);
      const auto continues = [&](auto neighbour) HWY_ATTR {
        const auto is_near = hn::Le(hn::Abs(hn::Sub(here, neighbour)), hn::Set(df, 1.0f));
        return bits_of(df, hn::And(is_near, hn::Gt(hn::Mul(here, neighbour), zero)));  // signs are labels
      };
      measured |= bits_of(df, hn::Ne(here, zero)) << i;
      left |= continues(hn::LoadU(df, at - 1)) << i;
      up |= continues(hn::LoadU(df, above + begin + i)) << i;
    }
    const std::size_t w{static_cast<std::size_t>(begin / word)};
    bits.is_measured[w] = measured;
    bits.continues_left[w] = left;
    bits.continues_above[w] = up;
  }
}

}  // namespace
}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FlagSurfaces);

void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   SurfaceBits& bits) {
  HWY_DYNAMIC_DISPATCH(FlagSurfaces)(obstacle, road, above, width, labelled, bits);
}

}  // namespace stereogrid
#endif
