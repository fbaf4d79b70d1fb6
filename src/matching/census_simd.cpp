// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
// Compiled once per instruction set; Highway picks one at run time. Vectors run along the pixels of a row.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matching/census_simd.cpp"  // NOLINT
#include "hwy/foreach_target.h"                        // IWYU pragma: keep
// after foreach_target
#include "hwy/highway.h"
#include "matching/census_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

void CensusRow(const std::uint8_t* const* window, int width, std::uint32_t* out) {
  const hn::ScalableTag<std::uint8_t> d8;
  const int lanes{static_cast<int>(hn::Lanes(d8))};
  const auto one = hn::Set(d8, std::uint8_t{1});
  for (int u{0}; u < width; u += lanes) {
    // the descriptor's four bytes, most significant first; comparisons come in the order of `census`
    auto bytes_0 = hn::Zero(d8);
    auto bytes_1 = hn::Zero(d8);
    auto bytes_2 = hn::Zero(d8);
    auto bytes_3 = hn::Zero(d8);
    int bit{census_bits};
    for (int j{-census_half_v}; j <= 0; ++j) {
      const int last{j < 0 ? census_half_u : -1};
      for (int i{-census_half_u}; i <= last; ++i) {
        const auto pixel = hn::LoadU(d8, window[census_half_v + j] + u + i);
        const auto mirrored = hn::LoadU(d8, window[census_half_v - j] + u - i);
        const auto is_darker = hn::IfThenElseZero(hn::Lt(pixel, mirrored), one);
        --bit;
        auto& bytes = bit >= 24 ? bytes_3 : (bit >= 16 ? bytes_2 : (bit >= 8 ? bytes_1 : bytes_0));
        bytes = hn::Or(hn::Add(bytes, bytes), is_darker);
      }
    }
    hn::StoreInterleaved4(bytes_0, bytes_1, bytes_2, bytes_3, d8, reinterpret_cast<std::uint8_t*>(out + u));
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace stereogrid {

HWY_EXPORT(CensusRow);

void census_row(const std::uint8_t* const* window, int width, std::uint32_t* out) {
  HWY_DYNAMIC_DISPATCH(CensusRow)(window, width, out);
}

}  // namespace stereogrid
#endif
