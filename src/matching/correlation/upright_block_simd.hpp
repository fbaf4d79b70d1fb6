// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// From the summed costs of some pixels of a row to their candidates. Included once per instruction set by
// upright_simd.hpp; the guard works per target.
#if defined(STEREOGRID_UPRIGHT_BLOCK_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_UPRIGHT_BLOCK_SIMD
#undef STEREOGRID_UPRIGHT_BLOCK_SIMD
#else
#define STEREOGRID_UPRIGHT_BLOCK_SIMD
#endif

#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlation/correlate_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::ScalableTag<std::uint8_t>;
using Words = hn::ScalableTag<std::uint16_t>;
using Ints = hn::CappedTag<std::int32_t, 16>;

// Costs of up to 64 times `words` shifts. It goes step by step, each for all pixels, without waits for values just
// written: smallest costs, which shifts have them, candidates; the last with vectors along the pixels.
template <int words>
class UprightBlock {
 public:
  static constexpr int pixels{32};
  static constexpr int n{64 * words};  // shifts with padding
  static constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};
  static constexpr int vectors{n / (2 * lanes)};
  using V16 = hn::Vec<Words>;

  // Window sums of a pixel: even and odd shifts separately, as vectors of bytes yield them without shuffling.
  struct Sums {
    HWY_INLINE Sums() {}  // the compiler's own would not be compiled for the instruction set
    V16 even[vectors];
    V16 odd[vectors];
  };

  UprightBlock(Shifts shifts, int uniqueness_1024) : shifts_{shifts}, uniqueness_1024_{uniqueness_1024} {
    for (int k{0}; k < n; ++k) {
      beyond_[k % 2 * (n / 2) + k / 2] = k < shifts.count ? std::uint16_t{0} : std::uint16_t{65535};
    }
  }

  // Costs of a pixel of the block.
  HWY_INLINE void take(const Sums& box, int pixel) {
    shifts_.count < n ? take_as<true>(box, pixel) : take_as<false>(box, pixel);
  }

  // Candidates of the first `count` pixels, to u and on; with vectors that run over.
  HWY_INLINE void finish(int u, int count, CandidateRow& out) {
    find_least();
    mark_shifts(count);
    for (int i{0}; i < pixels; i += static_cast<int>(hn::Lanes(Ints{}))) candidates_at(i, u + i, out);
  }

 private:
  using IntVector = hn::Vec<Ints>;

  template <bool is_padded>
  HWY_INLINE void take_as(const Sums& box, int pixel) {
    const Words d16;
    std::uint16_t* const costs{costs_ + pixel * n};
    auto least = hn::Set(d16, std::uint16_t{65535});
    for (int i{0}; i < vectors; ++i) {
      auto even = box.even[i];
      auto odd = box.odd[i];
      if constexpr (is_padded) {
        even = hn::Or(even, hn::Load(d16, beyond_ + i * lanes));
        odd = hn::Or(odd, hn::Load(d16, beyond_ + (vectors + i) * lanes));
      }
      hn::Store(even, d16, costs + i * lanes);
      hn::Store(odd, d16, costs + (vectors + i) * lanes);
      least = i == 0 ? hn::Min(even, odd) : hn::Min(least, hn::Min(even, odd));
    }
    hn::Store(least, d16, least_ + pixel * lanes);
  }

  template <class D16, class V>
  static HWY_INLINE auto folded([[maybe_unused]] D16 d16, V values) {
    if constexpr (hn::MaxLanes(D16{}) > 8) {
      const hn::Half<D16> half;
      return folded(half, hn::Min(hn::LowerHalf(half, values), hn::UpperHalf(half, values)));
    } else {
      return values;
    }
  }

  // Lanes of 2 × `size` bits whose lower halves hold minima of a, the upper ones of b.
  template <class D>
  static HWY_INLINE V16 zipped_minima(D d, V16 a, V16 b) {
    const Words d16;
    const auto low = hn::InterleaveLower(d, hn::BitCast(d, a), hn::BitCast(d, b));
    const auto high = hn::InterleaveUpper(d, hn::BitCast(d, a), hn::BitCast(d, b));
    return hn::Min(hn::BitCast(d16, low), hn::BitCast(d16, high));
  }

  // The smallest costs of the block's pixels, eight at a time, and what a shift must cost so as not to be close to
  // them.
  HWY_INLINE void find_least() {
    const Words d16;
    const hn::Repartition<std::uint32_t, Words> d32;
    const hn::Repartition<std::uint64_t, Words> d64;
    for (int i{0}; i < pixels; i += 8) {
      const auto pair = [&](int j) {
        const std::uint16_t* const at{least_ + (i + j) * lanes};
        return zipped_minima(d16, hn::Load(d16, at), hn::Load(d16, at + lanes));
      };
      const auto low = zipped_minima(d32, pair(0), pair(2));
      const auto high = zipped_minima(d32, pair(4), pair(6));
      const hn::FixedTag<std::uint16_t, 8> eight;
      const hn::FixedTag<std::uint32_t, 4> four;
      const auto set = [&](int value) { return hn::Set(eight, static_cast<std::uint16_t>(value)); };
      const auto keep_twice = [&](auto values, std::uint32_t* to) {
        hn::Store(hn::BitCast(four, hn::InterleaveLower(eight, values, values)), four, to + i);
        hn::Store(hn::BitCast(four, hn::InterleaveUpper(eight, values, values)), four, to + i + 4);
      };
      const auto cost = folded(d16, zipped_minima(d64, low, high));
      // highest_rival: ⌈cost · uniqueness / 1024⌉ above the cost, less one
      const auto share_high = hn::MulHigh(cost, set(uniqueness_1024_));
      const auto share_low = hn::Mul(cost, set(uniqueness_1024_));
      const auto rest = hn::Min(hn::And(share_low, set(1023)), set(1));
      const auto share = hn::Add(hn::Add(hn::ShiftLeft<6>(share_high), hn::ShiftRight<10>(share_low)), rest);
      const auto rival_limit = hn::Add(cost, hn::Max(share, set(1)));
      hn::Store(cost, eight, cost_ + i);
      hn::Store(rival_limit, eight, rival_limit_ + i);
      keep_twice(cost, twice_least_);
      keep_twice(rival_limit, twice_rival_limit_);
    }
  }

  // Which shifts cost the least, and which are close to it.
  HWY_NOINLINE void mark_shifts(int count) {
    const Words d16;
    const hn::Repartition<std::uint32_t, Words> d32;
    for (int pixel{0}; pixel < count; ++pixel) {
      const std::uint16_t* const costs{costs_ + pixel * n};
      const auto least = hn::BitCast(d16, hn::Set(d32, twice_least_[pixel]));
      const auto rival_limit = hn::BitCast(d16, hn::Set(d32, twice_rival_limit_[pixel]));
      for (int i{0}; i < 2 * vectors; ++i) {
        const int place{i * lanes};
        const auto cost = hn::Load(d16, costs + place);
        const auto bits = [&](std::uint32_t(&of)[2 * words][pixels]) {
          return reinterpret_cast<std::uint8_t*>(&of[place / 32][pixel]) + place % 32 / 8;
        };
        hn::StoreMaskBits(d16, hn::Eq(cost, least), bits(is_least_));
        hn::StoreMaskBits(d16, hn::Lt(cost, rival_limit), bits(is_close_));
      }
    }
  }

  HWY_INLINE static IntVector set_bits(IntVector words32) {
    const hn::Rebind<std::uint32_t, Ints> unsigned32;
    return hn::BitCast(Ints{}, hn::PopulationCount(hn::BitCast(unsigned32, words32)));
  }

  // Place of the first bit that is set; none: beyond all bits.
  HWY_INLINE static IntVector first_of(const std::uint32_t (*bits)[pixels], int pixel) {
    const Ints ints;
    auto place = hn::Set(ints, n / 2);
    for (int i{words - 1}; i >= 0; --i) {
      const auto word = hn::Load(ints, reinterpret_cast<const std::int32_t*>(bits[i] + pixel));
      const auto below = set_bits(hn::AndNot(word, hn::Sub(word, hn::Set(ints, 1))));
      place = hn::IfThenElse(hn::Eq(word, hn::Zero(ints)), place, hn::Add(below, hn::Set(ints, 32 * i)));
    }
    return place;
  }

  HWY_INLINE IntVector close_shifts(int pixel) const {
    const Ints ints;
    auto count = hn::Zero(ints);
    for (const auto& word : is_close_) {
      count = hn::Add(count, set_bits(hn::Load(ints, reinterpret_cast<const std::int32_t*>(word + pixel))));
    }
    return count;
  }

  HWY_INLINE void candidates_at(int pixel, int u, CandidateRow& out) const {
    const Ints ints;
    const hn::Rebind<std::uint16_t, Ints> d16;
    const hn::Rebind<std::int16_t, Ints> signed16;
    const auto set = [&](int value) { return hn::Set(ints, value); };
    const auto even = first_of(is_least_, pixel);
    const auto odd = first_of(is_least_ + words, pixel);
    const auto best = hn::Min(hn::Add(even, even), hn::Add(hn::Add(odd, odd), set(1)));
    // the neighbours' costs lie side by side among those of the other parity
    const auto other = hn::Sub(set(n / 2), hn::Mul(hn::And(best, set(1)), set(n / 2)));
    const auto beside = hn::Add(other, hn::ShiftRight<1>(hn::Sub(best, set(1))));
    const auto of_pixel = hn::Add(hn::Mul(hn::Iota(ints, 0), set(n)), set(pixel * n));
    const auto place = hn::Min(hn::Add(of_pixel, beside), set(pixels * n - 1));
    const auto both = hn::GatherOffset(ints, reinterpret_cast<const std::int32_t*>(costs_), hn::Add(place, place));
    const auto before = hn::And(both, set(65535));
    const auto after = hn::And(hn::ShiftRight<16>(both), set(65535));
    const auto has_before = hn::Gt(best, set(0));
    const auto has_after = hn::Lt(best, set(shifts_.count - 1));
    const auto rival_limit = hn::PromoteTo(ints, hn::Load(d16, rival_limit_ + pixel));
    const auto cost = hn::PromoteTo(ints, hn::Load(d16, cost_ + pixel));
    const auto close = close_shifts(pixel);
    const auto one_if = [&](auto condition) { return hn::IfThenElseZero(condition, set(1)); };
    const auto near = hn::Add(one_if(hn::And(has_before, hn::Lt(before, rival_limit))),
                              one_if(hn::And(has_after, hn::Lt(after, rival_limit))));
    const auto inside = hn::And(has_before, has_after);
    const auto store = [&](IntVector values, std::uint16_t* to) { hn::StoreU(hn::DemoteTo(d16, values), d16, to + u); };
    store(cost, out.cost());
    store(hn::Sub(hn::Sub(close, set(1)), near), out.rivals());
    store(hn::IfThenElse(inside, before, cost), out.before());
    store(hn::IfThenElse(inside, after, cost), out.after());
    hn::StoreU(hn::DemoteTo(signed16, best), signed16, out.shift() + u);
  }

  Shifts shifts_;
  int uniqueness_1024_;
  alignas(64) std::uint16_t beyond_[n];                // [place]: 65535 for shifts that are not searched
  alignas(64) std::uint16_t costs_[pixels * n + 2]{};  // [pixel][parity][shift / 2]; read in pairs
  alignas(64) std::uint16_t least_[pixels * lanes]{};  // [pixel]: in each lane the smallest cost that was there
  alignas(64) std::uint16_t cost_[pixels];             // the smallest
  alignas(64) std::uint16_t rival_limit_[pixels];
  alignas(64) std::uint32_t twice_least_[pixels];  // as two numbers of 16 bits, likewise below
  alignas(64) std::uint32_t twice_rival_limit_[pixels];
  // a bit for each shift: words of even ones, words of odd ones
  alignas(64) std::uint32_t is_least_[2 * words][pixels]{};
  alignas(64) std::uint32_t is_close_[2 * words][pixels]{};
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
