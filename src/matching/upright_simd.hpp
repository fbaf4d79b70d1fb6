// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// The upright hypothesis of the double correlation, a row at a time, with vectors along the shifts of a pixel. Included
// once per instruction set by correlate_simd.cpp; the guard works per target.
#if defined(STEREOGRID_UPRIGHT_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_UPRIGHT_SIMD
#undef STEREOGRID_UPRIGHT_SIMD
#else
#define STEREOGRID_UPRIGHT_SIMD
#endif

#include <algorithm>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlate_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::ScalableTag<std::uint8_t>;
using Words = hn::ScalableTag<std::uint16_t>;

template <class D16, class V16>
HWY_INLINE std::uint16_t smallest_lane(D16 d16, V16 v) {
  if constexpr (hn::MaxLanes(D16{}) > 8) {
    const hn::Half<D16> half;
    return smallest_lane(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  } else {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4
    return static_cast<std::uint16_t>(_mm_cvtsi128_si32(_mm_minpos_epu16(v.raw)));
#else
    return hn::GetLane(hn::MinOfLanes(d16, v));
#endif
  }
}

// Descriptors that enter the window at its lower edge and leave it above; null: nothing leaves.
struct RowPair {
  const std::uint8_t* left;
  const std::uint8_t* right_reversed;
};

// Costs of the shifts first … first + count − 1, in `vectors` vectors of bytes. Sums of 16 bits are kept in two vectors
// for each of these: even shifts and odd shifts, which needs no shuffling.
template <int vectors>
class UprightRows {
 public:
  static int padded_count() { return vectors * static_cast<int>(hn::Lanes(Bytes{})); }
  static std::size_t memory(int width) {
    return static_cast<std::size_t>(width + 4) * static_cast<std::size_t>(padded_count());
  }

  UprightRows(int width, Shifts shifts, int half_window, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        shifts_{shifts},
        n_{padded_count()},
        beyond_{reinterpret_cast<std::uint16_t*>(memory)},
        box_{beyond_ + n_},
        columns_{memory + 4 * n_} {
    std::fill(columns_, columns_ + static_cast<std::ptrdiff_t>(width) * n_, std::uint8_t{0});
    for (int k{0}; k < n_; ++k) beyond_[place(k)] = k < shifts.count ? std::uint16_t{0} : std::uint16_t{65535};
  }

  void add_row(RowPair entering) {
    for (int u{0}; u < width_; ++u) update_column(u, entering, entering, false);
  }

  void finish_row(RowPair entering, RowPair leaving, bool something_leaves, CandidateRow& out) {
    Sums box{};
    for (int i{0}; i < vectors; ++i) box.even[i] = box.odd[i] = hn::Zero(Words{});
    const int ahead{std::min(half_, width_)};
    for (int u{0}; u < ahead; ++u) update_column(u, entering, leaving, something_leaves);
    for (int i{-half_}; i < half_; ++i) add_column(std::clamp(i, 0, width_ - 1), box);
    for (int u{0}; u < width_; ++u) {
      if (u + half_ < width_) update_column(u + half_, entering, leaving, something_leaves);
      add_column(std::min(u + half_, width_ - 1), box);
      if (u > 0) subtract_column(std::max(u - half_ - 1, 0), box);
      find_best(u, box, out);
    }
  }

 private:
  using V8 = hn::Vec<Bytes>;
  using V16 = hn::Vec<Words>;
  struct Sums {
    V16 even[vectors];
    V16 odd[vectors];
  };

  [[nodiscard]] int place(int k) const { return (k & 1) * (n_ / 2) + k / 2; }
  [[nodiscard]] std::uint8_t* column(int u) const { return columns_ + static_cast<std::ptrdiff_t>(u) * n_; }

  [[nodiscard]] HWY_INLINE V8 differing_bits(RowPair rows, int u, int i) const {
    const Bytes d8;
    const std::uint8_t* right{rows.right_reversed + (width_ - 1 - u) + shifts_.first};
    return hn::PopulationCount(hn::Xor(hn::Set(d8, rows.left[u]), hn::LoadU(d8, right + i * hn::Lanes(d8))));
  }

  HWY_INLINE void update_column(int u, RowPair entering, RowPair leaving, bool something_leaves) {
    const Bytes d8;
    std::uint8_t* sums{column(u)};
    for (int i{0}; i < vectors; ++i) {
      std::uint8_t* at{sums + i * hn::Lanes(d8)};
      auto sum = hn::Add(hn::Load(d8, at), differing_bits(entering, u, i));
      if (something_leaves) sum = hn::Sub(sum, differing_bits(leaving, u, i));
      hn::Store(sum, d8, at);
    }
  }

  HWY_INLINE void add_column(int u, Sums& box) const {
    const Bytes d8;
    const Words d16;
    for (int i{0}; i < vectors; ++i) {
      const auto both = hn::BitCast(d16, hn::Load(d8, column(u) + i * hn::Lanes(d8)));
      box.even[i] = hn::Add(box.even[i], hn::And(both, hn::Set(d16, std::uint16_t{255})));
      box.odd[i] = hn::Add(box.odd[i], hn::ShiftRight<8>(both));
    }
  }

  HWY_INLINE void subtract_column(int u, Sums& box) const {
    const Bytes d8;
    const Words d16;
    for (int i{0}; i < vectors; ++i) {
      const auto both = hn::BitCast(d16, hn::Load(d8, column(u) + i * hn::Lanes(d8)));
      box.even[i] = hn::Sub(box.even[i], hn::And(both, hn::Set(d16, std::uint16_t{255})));
      box.odd[i] = hn::Sub(box.odd[i], hn::ShiftRight<8>(both));
    }
  }

  HWY_INLINE void find_best(int u, const Sums& box, CandidateRow& out) {
    const Words d16;
    const int lanes{static_cast<int>(hn::Lanes(d16))};
    const auto highest = hn::Set(d16, std::uint16_t{65535});
    Sums costs;
    auto least = highest;
    for (int i{0}; i < vectors; ++i) {
      costs.even[i] = hn::Or(box.even[i], hn::Load(d16, beyond_ + i * lanes));
      costs.odd[i] = hn::Or(box.odd[i], hn::Load(d16, beyond_ + n_ / 2 + i * lanes));
      hn::Store(costs.even[i], d16, box_ + i * lanes);
      hn::Store(costs.odd[i], d16, box_ + n_ / 2 + i * lanes);
      least = hn::Min(least, hn::Min(costs.even[i], costs.odd[i]));
    }
    const std::uint16_t cost{smallest_lane(d16, least)};
    const auto wanted = hn::Set(d16, cost);
    const auto iota = hn::ShiftLeft<1>(hn::Iota(d16, std::uint16_t{0}));
    auto first = highest;
    for (int i{0}; i < vectors; ++i) {
      const auto even = hn::Add(iota, hn::Set(d16, static_cast<std::uint16_t>(2 * i * lanes)));
      const auto odd = hn::Add(iota, hn::Set(d16, static_cast<std::uint16_t>(2 * i * lanes + 1)));
      first = hn::Min(first, hn::IfThenElse(hn::Eq(costs.even[i], wanted), even, highest));
      first = hn::Min(first, hn::IfThenElse(hn::Eq(costs.odd[i], wanted), odd, highest));
    }
    const int best{smallest_lane(d16, first)};
    auto others = highest;
    for (int i{0}; i < vectors; ++i) {
      // wraps round for shifts before best − 1
      const auto distance = hn::Add(iota, hn::Set(d16, static_cast<std::uint16_t>(2 * i * lanes - best + 1)));
      const auto three = hn::Set(d16, std::uint16_t{3});
      others = hn::Min(others, hn::IfThenElse(hn::Lt(distance, three), highest, costs.even[i]));
      // an odd shift lies one further
      const auto further = hn::Add(distance, hn::Set(d16, std::uint16_t{1}));
      others = hn::Min(others, hn::IfThenElse(hn::Lt(further, three), highest, costs.odd[i]));
    }
    const bool inside{best > 0 && best < shifts_.count - 1};
    out.cost()[u] = cost;
    out.runner_up()[u] = smallest_lane(d16, others);
    out.before()[u] = inside ? box_[place(best - 1)] : cost;
    out.after()[u] = inside ? box_[place(best + 1)] : cost;
    out.shift()[u] = static_cast<std::int16_t>(shifts_.first + best);
  }

  int width_;
  int half_;
  Shifts shifts_;
  int n_;
  std::uint16_t* beyond_;  // [place]: 65535 for shifts that are not searched
  std::uint16_t* box_;     // [place]: costs of the current pixel
  std::uint8_t* columns_;  // [u][shift]: differing bits summed over the window's rows
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
