// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/surfaces_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                          // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/surfaces_simd.hpp"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

void FlagSurfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                  std::uint8_t* flags) {
  const hn::CappedTag<float, 16> df;
  const hn::Rebind<std::int32_t, decltype(df)> d32;
  const hn::Rebind<std::uint8_t, decltype(df)> d8;
  const int lanes{static_cast<int>(hn::Lanes(df))};
  const auto zero = hn::Zero(df);
  int u{0};
  for (; u + lanes <= width; u += lanes) {
    hn::StoreU(hn::Sub(hn::LoadU(df, obstacle + u), hn::LoadU(df, road + u)), df, labelled + u);
  }
  for (; u < width; ++u) labelled[u] = obstacle[u] - road[u];
  for (u = 0; u < width; u += lanes) {
    const auto here = hn::LoadU(df, labelled + u);
    const auto flag = [&](auto condition, std::uint8_t bit) {
      return hn::IfThenElseZero(hn::RebindMask(d32, condition), hn::Set(d32, std::int32_t{bit}));
    };
    const auto continues = [&](auto neighbour) {
      const auto is_near = hn::Le(hn::Abs(hn::Sub(here, neighbour)), hn::Set(df, 1.0f));
      return hn::And(is_near, hn::Gt(hn::Mul(here, neighbour), zero));  // signs are labels
    };
    const auto all = hn::Or(flag(hn::Ne(here, zero), is_measured),
                            hn::Or(flag(continues(hn::LoadU(df, labelled + u - 1)), continues_left),
                                   flag(continues(hn::LoadU(df, above + u)), continues_above)));
    hn::StoreU(hn::DemoteTo(d8, all), d8, flags + u);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(FlagSurfaces);

void flag_surfaces(const float* obstacle, const float* road, const float* above, int width, float* labelled,
                   std::uint8_t* flags) {
  HWY_DYNAMIC_DISPATCH(FlagSurfaces)(obstacle, road, above, width, labelled, flags);
}

}  // namespace stereogrid
#endif
