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
#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlation/correlate_simd.hpp"
#include "matching/correlation/upright_block_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Descriptors of an image row.
struct RowPair {
  const std::uint32_t* left;  // four times the byte: a vector is then filled without shuffling
  const std::uint8_t* right_reversed;
};

// Costs of the shifts 0 … count − 1, padded to `words` times 64.
template <int words>
class UprightRows {
 public:
  static std::size_t memory(int width, int half_window) {
    return static_cast<std::size_t>(width + 2 * half_window + 1) * static_cast<std::size_t>(n);
  }

  UprightRows(int width, Shifts shifts, int half_window, int uniqueness_1024, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        columns_{memory + static_cast<std::ptrdiff_t>(half_window + 1) * n},
        block_{shifts, uniqueness_1024} {
    std::fill(column(0), column(width), std::uint8_t{0});
  }

  void add_row(RowPair entering) {
    for (int u{0}; u < width_; ++u) update_column<false>(u, rows(entering), rows(entering), column(u));
  }

  void finish_row(RowPair entering, RowPair leaving, bool something_leaves, CandidateRow& out) {
    if (something_leaves) {
      finish_row_as<true>(rows(entering), rows(leaving), out);
    } else {
      finish_row_as<false>(rows(entering), rows(entering), out);
    }
  }

 private:
  using Block = UprightBlock<words>;
  using Sums = typename Block::Sums;
  using V8 = hn::Vec<Bytes>;
  static constexpr int n{Block::n};
  static constexpr int vectors{Block::vectors};

  // The loops below write bytes, which may alias members: local copies avoid reloads.
  struct Rows {
    const std::uint32_t* left;
    const std::uint8_t* right;  // column 0 at shift 0; column u is u before it
  };
  [[nodiscard]] Rows rows(RowPair pair) const { return {pair.left, pair.right_reversed + width_ - 1}; }
  [[nodiscard]] std::uint8_t* column(std::ptrdiff_t u) const { return columns_ + u * n; }

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

  // Columns beyond both ends repeat the border; the left ones are ready with the first, the right ones with the last.
  template <bool something_leaves>
  HWY_INLINE void update_columns(std::ptrdiff_t begin, std::ptrdiff_t end, Rows entering, Rows leaving) const {
    const std::ptrdiff_t last{std::min<std::ptrdiff_t>(end, width_)};
    std::uint8_t* at{column(begin)};
    for (std::ptrdiff_t u{begin}; u < last; ++u, at += n) update_column<something_leaves>(u, entering, leaving, at);
    if (begin == 0) {
      for (int i{1}; i <= half_ + 1; ++i) std::copy_n(column(0), n, column(-i));
    }
    if (begin < width_ && end >= width_) {
      for (int i{0}; i < half_; ++i) std::copy_n(column(width_ - 1), n, column(width_ + i));
    }
  }

  static HWY_INLINE void add_column(const std::uint8_t* entering, Sums& box) {
    const Bytes d8;
    const Words d16;
    for (int i{0}; i < vectors; ++i) {
      const auto in = hn::BitCast(d16, hn::Load(d8, entering + i * hn::Lanes(d8)));
      box.even[i] = hn::Add(box.even[i], hn::And(in, hn::Set(d16, std::uint16_t{255})));
      box.odd[i] = hn::Add(box.odd[i], hn::ShiftRight<8>(in));
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

  template <bool something_leaves>
  HWY_NOINLINE void finish_row_as(Rows entering, Rows leaving, CandidateRow& out) {
    Sums box;
    for (int i{0}; i < vectors; ++i) box.even[i] = box.odd[i] = hn::Zero(Words{});
    update_columns<something_leaves>(0, half_, entering, leaving);
    // one column too many, which the first step takes away
    for (int i{-half_ - 1}; i < half_; ++i) add_column(column(i), box);
    for (int start{0}; start < width_; start += Block::pixels) {
      const int end{std::min(start + Block::pixels, width_)};
      update_columns<something_leaves>(start + half_, end + half_, entering, leaving);
      const std::uint8_t* in{column(start + half_)};
      const std::uint8_t* out_of{column(start - half_ - 1)};
      for (int i{0}; i < end - start; ++i, in += n, out_of += n) {
        move_box(in, out_of, box);
        block_.take(box, i);
      }
      block_.finish(start, end - start, out);
    }
  }

  int width_;
  int half_;
  std::uint8_t* columns_;  // [u][shift]: differing bits summed over the window's rows
  Block block_;            // at work
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
