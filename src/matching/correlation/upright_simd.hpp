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
#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlation/differing_bits_simd.hpp"
#include "matching/correlation/simd.hpp"
#include "matching/correlation/upright_block_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Order in which the interleaved halves of a vector's blocks are in the order of `bytes`.
HWY_INLINE V8 in_column_order(V8 bytes) {
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX3
  return V8{_mm512_permutexvar_epi64(_mm512_setr_epi64(0, 4, 1, 5, 2, 6, 3, 7), bytes.raw)};
#elif HWY_TARGET == HWY_AVX2
  return V8{_mm256_permute4x64_epi64(bytes.raw, 0xd8)};
#else
  return bytes;
#endif
}

#if HWY_ARCH_X86 && HWY_TARGET <= HWY_SSSE3
// For weighted_lower and weighted_upper: scale, −scale.
constexpr std::uint16_t weight_of_columns(unsigned scale) {
  return static_cast<std::uint16_t>((256 - scale) << 8 | scale);
}
HWY_INLINE V16 weighted(V8 pairs, V16 weights) {
#if HWY_TARGET <= HWY_AVX3
  return V16{_mm512_maddubs_epi16(pairs.raw, weights.raw)};
#elif HWY_TARGET == HWY_AVX2
  return V16{_mm256_maddubs_epi16(pairs.raw, weights.raw)};
#else
  return V16{_mm_maddubs_epi16(pairs.raw, weights.raw)};
#endif
}
// Weighted differences of the lower halves of blocks, and of the upper ones.
HWY_INLINE V16 weighted_lower(V8 in, V8 out, V16 weights) {
  return weighted(hn::InterleaveLower(Bytes{}, in, out), weights);
}
HWY_INLINE V16 weighted_upper(V8 in, V8 out, V16 weights) {
  return weighted(hn::InterleaveUpper(Bytes{}, in, out), weights);
}
#else
constexpr std::uint16_t weight_of_columns(unsigned scale) {
  return static_cast<std::uint16_t>(scale);
}
HWY_INLINE V16 weighted_lower(V8 in, V8 out, V16 weights) {
  const Words d16;
  const auto wide = [&](V8 bytes) { return hn::PromoteTo(d16, hn::LowerHalf(bytes)); };
  return hn::Mul(hn::Sub(wide(in), wide(out)), weights);
}
HWY_INLINE V16 weighted_upper(V8 in, V8 out, V16 weights) {
  const Words d16;
  const auto wide = [&](V8 bytes) { return hn::PromoteTo(d16, hn::UpperHalf(hn::Half<Bytes>{}, bytes)); };
  return hn::Mul(hn::Sub(wide(in), wide(out)), weights);
}
#endif

// Costs of the shifts 0 … count − 1, padded to `shift_count`, a multiple of 64.
template <int shift_count, int tile>
class UprightRows {
 public:
  using Block = UprightBlock<shift_count, tile>;

  static std::ptrdiff_t memory(int width, int half_window) {
    return memory_of_columns(width, half_window) + (DifferingBits::memory(width, n) + 63) / 64 * 64;
  }

  UprightRows(int width, Shifts shifts, int half_window, int uniqueness_1024, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        is_padded_{shifts.count < n},
        columns_{memory + static_cast<std::ptrdiff_t>(half_window + 1) * n},
        bits_{width, n, memory + memory_of_columns(width, half_window)},
        block_{shifts, uniqueness_1024} {
    std::fill(column(0), column(width), std::uint8_t{0});
    for (int k{0}; k < n; ++k) {
      const bool is_searched{k < shifts.count};
      first_sums_[k] = is_searched ? Block::first_sum(k) : std::uint16_t{65535};
      weights_[k] = is_searched ? weight_of_columns(Block::scale) : std::uint16_t{0};
    }
  }

  void add_row(const std::uint8_t* left, const std::uint8_t* right_reversed) {
    bits_.take_entering(left, right_reversed);
    bits_.take_leaving(left, right_reversed);
    change_columns(0, width_, [](const auto& pixel, int i) { return DifferingBits::entering(pixel, i); });
  }

  // Adds a row, takes one away.
  void finish_row(const std::uint8_t* left, const std::uint8_t* right_reversed, const std::uint8_t* leaving_left,
                  const std::uint8_t* leaving_right_reversed, const Contest& contest, CandidateRow& out) {
    bits_.take_entering(left, right_reversed);
    bits_.take_leaving(leaving_left, leaving_right_reversed);
    is_padded_ ? finish_row_as<true>(contest, out) : finish_row_as<false>(contest, out);
  }

 private:
  using Sums = typename Block::Sums;
  static constexpr int n{Block::n};
  static constexpr int lanes{bytes_of_vector};
  static constexpr int vectors{n / lanes};

  static std::ptrdiff_t memory_of_columns(int width, int half_window) {
    return static_cast<std::ptrdiff_t>(width + 2 * half_window + 1) * n;
  }

  [[nodiscard]] std::uint8_t* column(std::ptrdiff_t u) const { return columns_ + u * n; }

  // Adds change(pixel, i) to the i-th vector of each column.
  template <class Change>
  HWY_INLINE void change_columns(std::ptrdiff_t begin, std::ptrdiff_t end, const Change& change) const {
    const Bytes d8;
    std::uint8_t* at{column(begin)};
    const auto bits = bits_;  // the loop writes bytes, which may alias members
    for (std::ptrdiff_t u{begin}; u < end;) {
      const std::uint8_t* right{bits.right(u)};
      for (const std::ptrdiff_t steady_end{std::min(u + bits.steady(u), end)}; u < steady_end; ++u, --right) {
        const auto pixel = bits.pixel(u, right);
        for (int i{0}; i < vectors; ++i, at += lanes) {
          hn::Store(hn::Add(hn::Load(d8, at), in_column_order(change(pixel, i))), d8, at);
        }
      }
    }
  }

  // Columns beyond both ends repeat the border; the left ones are ready with the first, the right ones with the last.
  HWY_INLINE void update_columns(std::ptrdiff_t begin, std::ptrdiff_t end) const {
    change_columns(begin, std::min<std::ptrdiff_t>(end, width_), [](const auto& pixel, int i) {
      return hn::Sub(DifferingBits::entering(pixel, i), DifferingBits::leaving(pixel, i));
    });
    if (begin == 0) {
      for (int i{1}; i <= half_ + 1; ++i) std::copy_n(column(0), n, column(-i));
    }
    if (begin < width_ && end >= width_) {
      for (int i{0}; i < half_; ++i) std::copy_n(column(width_ - 1), n, column(width_ + i));
    }
  }

  // box += scale · (column entering − column leaving)
  template <bool is_padded>
  HWY_INLINE void move_box(const std::uint8_t* entering, const std::uint8_t* leaving, Sums& box) const {
    const Bytes d8;
    const Words d16;
    const auto weights = [&](int part) {
      return is_padded ? hn::Load(d16, weights_ + part * lanes / 2) : hn::Set(d16, weight_of_columns(Block::scale));
    };
    for (int i{0}; i < vectors; ++i) {
      const auto in = hn::Load(d8, entering + i * lanes);
      const auto out = hn::Load(d8, leaving + i * lanes);
      box.part[2 * i] = hn::Add(box.part[2 * i], weighted_lower(in, out, weights(2 * i)));
      box.part[2 * i + 1] = hn::Add(box.part[2 * i + 1], weighted_upper(in, out, weights(2 * i + 1)));
    }
  }

  template <bool is_padded>
  HWY_NOINLINE void finish_row_as(const Contest& contest, CandidateRow& out) {
    update_columns(0, half_);
    Sums box;
    for (int i{0}; i < Block::vectors; ++i) box.part[i] = hn::Load(Words{}, first_sums_ + i * lanes / 2);
    // one column too many, which the first step takes away
    for (int i{-half_ - 1}; i < half_; ++i) move_box<is_padded>(column(i), no_column_, box);
    for (int start{0}; start < width_; start += Block::pixels) {
      const int end{std::min(start + Block::pixels, width_)};
      update_columns(start + half_, end + half_);
      const std::uint8_t* in{column(start + half_)};
      const std::uint8_t* out_of{column(start - half_ - 1)};
      for (int i{0}; i < end - start; ++i, in += n, out_of += n) {
        move_box<is_padded>(in, out_of, box);
        block_.take(box, i);
      }
      block_.finish(start, end - start, contest, out);
    }
  }

  int width_;
  int half_;
  bool is_padded_;
  std::uint8_t* columns_;  // [u][shift]: differing bits summed over the window's rows, in column order
  DifferingBits bits_;
  alignas(64) std::uint8_t no_column_[n]{};
  alignas(64) std::uint16_t first_sums_[n];  // [shift]: 65535 where none is searched, which stays
  alignas(64) std::uint16_t weights_[n];     // [shift]: weight_of_columns, 0 where none is searched
  Block block_;                              // at work
};

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
