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
#include <bit>
#include <cstdint>
#include <type_traits>

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

// Descriptors of an image row.
struct RowPair {
  const std::uint32_t* left;  // four times the byte: a vector is then filled without shuffling
  const std::uint8_t* right_reversed;
};

// Costs of the shifts first … first + count − 1, in `vectors` vectors of bytes. Sums of 16 bits are kept in two vectors
// for each of these: even shifts and odd shifts, which needs no shuffling.
template <int vectors>
class UprightRows {
 public:
  static int padded_count() { return vectors * static_cast<int>(hn::Lanes(Bytes{})); }
  static std::size_t memory(int width) {
    return static_cast<std::size_t>(width + 3) * static_cast<std::size_t>(padded_count());
  }

  UprightRows(int width, Shifts shifts, int half_window, int uniqueness_1024, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        shifts_{shifts},
        uniqueness_1024_{uniqueness_1024},
        n_{padded_count()},
        beyond_{reinterpret_cast<std::uint16_t*>(memory)},
        nothing_{memory + 2 * n_},
        columns_{memory + 3 * n_} {
    std::fill(nothing_, nothing_ + n_, std::uint8_t{0});
    std::fill(columns_, columns_ + static_cast<std::ptrdiff_t>(width) * n_, std::uint8_t{0});
    for (int k{0}; k < n_; ++k)
      beyond_[(k & 1) * (n_ / 2) + k / 2] = k < shifts.count ? std::uint16_t{0} : std::uint16_t{65535};
  }

  void add_row(RowPair entering) {
    for (int u{0}; u < width_; ++u) {
      update_column<false>(u, rows(entering), rows(entering), columns_ + static_cast<std::ptrdiff_t>(u) * n_);
    }
  }

  void finish_row(RowPair entering, RowPair leaving, bool something_leaves, CandidateRow& out) {
    const auto finish = [&](auto is_padded) {
      if (something_leaves) {
        finish_row_as<true, is_padded>(entering, leaving, out);
      } else {
        finish_row_as<false, is_padded>(entering, leaving, out);
      }
    };
    if (shifts_.count < n_) {
      finish(std::true_type{});
    } else {
      finish(std::false_type{});
    }
  }

 private:
  using V8 = hn::Vec<Bytes>;
  using V16 = hn::Vec<Words>;
  struct Sums {
    HWY_INLINE Sums() {}  // the compiler's own would not be compiled for the instruction set
    V16 even[vectors];
    V16 odd[vectors];
  };

  // Bytes are written in the loops below; what is read there is kept in local variables, which they cannot change.
  struct Rows {
    const std::uint32_t* left;
    const std::uint8_t* right;  // of column 0 and the first shift; that of column u lies u before
  };
  [[nodiscard]] Rows rows(RowPair pair) const { return {pair.left, pair.right_reversed + width_ - 1 + shifts_.first}; }

  static HWY_INLINE V8 differing_bits(Rows rows, std::ptrdiff_t u, int i) {
    const Bytes d8;
    const hn::Repartition<std::uint32_t, Bytes> d32;
    const auto left = hn::BitCast(d8, hn::Set(d32, rows.left[u]));
    return hn::PopulationCount(hn::Xor(left, hn::LoadU(d8, rows.right - u + i * hn::Lanes(d8))));
  }

  template <bool something_leaves>
  static HWY_INLINE void update_column(std::ptrdiff_t u, Rows entering, Rows leaving, std::uint8_t* column) {
    const Bytes d8;
    for (int i{0}; i < vectors; ++i) {
      std::uint8_t* at{column + i * hn::Lanes(d8)};
      auto sum = hn::Add(hn::Load(d8, at), differing_bits(entering, u, i));
      if constexpr (something_leaves) sum = hn::Sub(sum, differing_bits(leaving, u, i));
      hn::Store(sum, d8, at);
    }
  }

  // box += column entering − column leaving
  static HWY_INLINE void move_box(const std::uint8_t* entering, const std::uint8_t* leaving, Sums& box) {
    const Bytes d8;
    const Words d16;
    const auto low = hn::Set(d16, std::uint16_t{255});
    for (int i{0}; i < vectors; ++i) {
      const auto in = hn::BitCast(d16, hn::Load(d8, entering + i * hn::Lanes(d8)));
      const auto out = hn::BitCast(d16, hn::Load(d8, leaving + i * hn::Lanes(d8)));
      box.even[i] = hn::Add(box.even[i], hn::Sub(hn::And(in, low), hn::And(out, low)));
      box.odd[i] = hn::Add(box.odd[i], hn::Sub(hn::ShiftRight<8>(in), hn::ShiftRight<8>(out)));
    }
  }

  template <bool something_leaves, bool is_padded>
  HWY_NOINLINE void finish_row_as(RowPair entering_pair, RowPair leaving_pair, CandidateRow& out) {
    const Rows entering{rows(entering_pair)};
    const Rows leaving{something_leaves ? rows(leaving_pair) : entering};
    const std::ptrdiff_t n{n_};
    const std::ptrdiff_t half{half_};
    const std::ptrdiff_t width{width_};
    std::uint8_t* const columns{columns_};
    const std::uint8_t* const nothing{nothing_};
    Sums box;
    for (int i{0}; i < vectors; ++i) box.even[i] = box.odd[i] = hn::Zero(Words{});
    for (std::ptrdiff_t u{0}; u < std::min(half, width); ++u) {
      update_column<something_leaves>(u, entering, leaving, columns + u * n);
    }
    for (std::ptrdiff_t i{-half}; i < half; ++i) {
      move_box(columns + std::clamp(i, std::ptrdiff_t{0}, width - 1) * n, nothing, box);
    }
    for (std::ptrdiff_t start{0}; start < width; start += block) {
      const std::ptrdiff_t end{std::min(start + block, width)};
      for (std::ptrdiff_t u{start}; u < end; ++u) {
        const std::ptrdiff_t ahead{u + half};
        if (ahead < width) update_column<something_leaves>(ahead, entering, leaving, columns + ahead * n);
        const std::ptrdiff_t behind{u - half - 1};
        move_box(columns + std::min(ahead, width - 1) * n,
                 u == 0 ? nothing : columns + std::max(behind, std::ptrdiff_t{0}) * n, box);
        find_minimum<is_padded>(box, beyond_, uniqueness_1024_, minima_[u - start]);
      }
      for (std::ptrdiff_t u{start}; u < end; ++u) out.set(static_cast<int>(u), candidate_at(minima_[u - start]));
    }
  }

  // A bit for each shift of one parity, per vector.
  static constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};
  using Bits =
      std::conditional_t<lanes == 32, std::uint32_t, std::conditional_t<lanes == 16, std::uint16_t, std::uint8_t>>;

  // A pixel's costs and what vectors tell of them. Numbers are read as they were written: anything else would have to
  // wait for the memory.
  struct alignas(64) Minimum {
    std::uint16_t costs[2][vectors * lanes];  // even shifts, odd shifts
    Bits is_least[2][vectors];
    Bits is_close[2][vectors];
    int cost;
    int rival_cost;
  };

  template <bool is_padded>
  static HWY_INLINE void find_minimum(const Sums& box, const std::uint16_t* beyond, int uniqueness, Minimum& minimum) {
    const Words d16;
    V16 even[vectors];
    V16 odd[vectors];
    auto least = hn::Set(d16, std::uint16_t{65535});
    for (int i{0}; i < vectors; ++i) {
      even[i] = box.even[i];
      odd[i] = box.odd[i];
      if constexpr (is_padded) {
        even[i] = hn::Or(even[i], hn::Load(d16, beyond + i * lanes));
        odd[i] = hn::Or(odd[i], hn::Load(d16, beyond + (vectors + i) * lanes));
      }
      hn::Store(even[i], d16, minimum.costs[0] + i * lanes);
      hn::Store(odd[i], d16, minimum.costs[1] + i * lanes);
      const auto lesser = hn::Min(even[i], odd[i]);
      least = i == 0 ? lesser : hn::Min(least, lesser);
    }
    minimum.cost = smallest_lane(d16, least);
    minimum.rival_cost = highest_rival(minimum.cost, uniqueness);
    const auto wanted = hn::Set(d16, static_cast<std::uint16_t>(minimum.cost));
    const auto too_dear = hn::Set(d16, static_cast<std::uint16_t>(minimum.rival_cost + 1));
    for (int i{0}; i < vectors; ++i) {
      store_bits(d16, hn::Eq(even[i], wanted), minimum.is_least[0][i]);
      store_bits(d16, hn::Eq(odd[i], wanted), minimum.is_least[1][i]);
      store_bits(d16, hn::Lt(even[i], too_dear), minimum.is_close[0][i]);
      store_bits(d16, hn::Lt(odd[i], too_dear), minimum.is_close[1][i]);
    }
  }

  static HWY_INLINE void store_bits(Words d16, hn::Mask<Words> mask, Bits& bits) {
    hn::StoreMaskBits(d16, mask, reinterpret_cast<std::uint8_t*>(&bits));
  }

  // The first shift of one parity, in steps of two; none: beyond all shifts. Up to 64 without a branch, which would
  // often be mispredicted.
  static HWY_INLINE int first_of(const Bits* bits) {
    constexpr int per_word{std::min(64 / lanes, vectors)};
    int place{lanes * vectors};
    for (int i{vectors - per_word}; i >= 0; i -= per_word) {
      std::uint64_t word{0};
      for (int j{0}; j < per_word; ++j) word |= static_cast<std::uint64_t>(bits[i + j]) << (lanes * j);
      const int first{lanes * i + std::popcount(~word & (word - 1))};
      place = per_word == vectors || word != 0 ? first : place;
    }
    return place;
  }

  HWY_INLINE Candidate candidate_at(const Minimum& minimum) const {
    const int best{std::min(2 * first_of(minimum.is_least[0]), 2 * first_of(minimum.is_least[1]) + 1)};
    const auto cost_at = [&](int k) { return int{minimum.costs[k & 1][k / 2]}; };
    const int before{best > 0 ? cost_at(best - 1) : 65535};
    const int after{best < shifts_.count - 1 ? cost_at(best + 1) : 65535};
    int close{-1 - (before <= minimum.rival_cost ? 1 : 0) - (after <= minimum.rival_cost ? 1 : 0)};
    for (int i{0}; i < vectors; ++i) {
      close += std::popcount(minimum.is_close[0][i]) + std::popcount(minimum.is_close[1][i]);
    }
    const bool inside{best > 0 && best < shifts_.count - 1};
    const auto word = [](int value) { return static_cast<std::uint16_t>(value); };
    return {word(minimum.cost), word(close), word(inside ? before : minimum.cost), word(inside ? after : minimum.cost),
            static_cast<std::int16_t>(shifts_.first + best)};
  }

  static constexpr int block{16};

  int width_;
  int half_;
  Shifts shifts_;
  int uniqueness_1024_;
  int n_;
  std::uint16_t* beyond_;  // [place]: 65535 for shifts that are not searched
  std::uint8_t* nothing_;  // a column of zeros
  Minimum minima_[block];  // of the pixels at work
  std::uint8_t* columns_;  // [u][shift]: differing bits summed over the window's rows
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
