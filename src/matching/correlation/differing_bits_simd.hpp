// SPDX-License-Identifier: Apache-2.0
//
// Differing bits of a left pixel's descriptor and the right ones at its shifts, in the image row that enters the window
// and the one that leaves it. Included once per instruction set; the guard works per target.
#if defined(STEREOGRID_DIFFERING_BITS_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_DIFFERING_BITS_SIMD
#undef STEREOGRID_DIFFERING_BITS_SIMD
#else
#define STEREOGRID_DIFFERING_BITS_SIMD
#endif

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlation/rival_limit_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr int bytes_of_vector{static_cast<int>(hn::MaxLanes(Bytes{}))};

// Both classes have the same members, for `width` pixels and `shifts` shifts.
#if HWY_ARCH_X86 && HWY_TARGET > HWY_AVX3 && HWY_TARGET <= HWY_SSSE3
// [left][right]: differing bits of two halves of descriptors, the right ones again and again.
using TablesOfHalves = std::array<std::array<std::uint8_t, bytes_of_vector>, 16>;
constexpr TablesOfHalves tables_of_halves() {
  TablesOfHalves tables{};
  for (std::size_t left{0}; left < 16; ++left) {
    for (std::size_t right{0}; right < bytes_of_vector; ++right) {
      tables[left][right] = static_cast<std::uint8_t>(std::popcount(left ^ right % 16));
    }
  }
  return tables;
}
alignas(64) constexpr TablesOfHalves differing_bits_of_halves{tables_of_halves()};

// A table for each half of a left descriptor maps halves of right ones to their differing bits. Halves of right
// descriptors are stored twice, in pieces of two vectors, of which one begins where the one before has its second: no
// vector that is loaded crosses a cache line.
class DifferingBits {
 public:
  struct Pixel {
    V8 in_low;
    V8 in_high;
    V8 out_low;
    V8 out_high;
    const std::uint8_t* right;
  };

  static constexpr int memory(int width, int shifts) { return 8 * (width + shifts + lanes) + 4 * left_length(width); }

  DifferingBits(int width, int shifts, std::uint8_t* memory)
      : width_{width}, shifts_{shifts}, lines_{memory}, left_{memory + 8 * (width + shifts + lanes)} {}

  void take_entering(const std::uint8_t* left, const std::uint8_t* right_reversed) { take(left, right_reversed, 0); }
  void take_leaving(const std::uint8_t* left, const std::uint8_t* right_reversed) { take(left, right_reversed, 1); }

  // Right descriptors of a pixel. Those of the next one lie a byte before, and so on for `steady` pixels.
  [[nodiscard]] HWY_INLINE const std::uint8_t* right(std::ptrdiff_t u) const {
    const std::ptrdiff_t of_line{(width_ - 1 - u) & (lanes - 1)};
    return lines_ + 8 * (width_ - 1 - u - of_line) + of_line;
  }
  [[nodiscard]] std::ptrdiff_t steady(std::ptrdiff_t u) const { return ((width_ - 1 - u) & (lanes - 1)) + 1; }

  [[nodiscard]] HWY_INLINE Pixel pixel(std::ptrdiff_t u, const std::uint8_t* right) const {
    const std::ptrdiff_t length{left_length(width_)};
    const auto table = [&](int part) {
      const std::uint8_t* const tables{differing_bits_of_halves[0].data()};
      return hn::Load(Bytes{}, tables + std::ptrdiff_t{left_[part * length + u]} * (lanes / 4));
    };
    return {table(0), table(1), table(2), table(3), right};
  }

  // At the shifts of the i-th vector.
  static HWY_INLINE V8 entering(const Pixel& pixel, int i) {
    return hn::Add(looked_up(pixel.in_low, pixel, 8 * i), looked_up(pixel.in_high, pixel, 8 * i + 2));
  }
  static HWY_INLINE V8 leaving(const Pixel& pixel, int i) {
    return hn::Add(looked_up(pixel.out_low, pixel, 8 * i + 4), looked_up(pixel.out_high, pixel, 8 * i + 6));
  }

 private:
  static constexpr int lanes{bytes_of_vector};
  static constexpr int left_length(int width) { return (width + lanes - 1) / lanes * lanes; }

  HWY_NOINLINE void take(const std::uint8_t* left, const std::uint8_t* right_reversed, int row) {
    const Bytes d8;
    const auto load = [&](int x) { return hn::LoadU(d8, right_reversed + x); };
    auto next = load(0);
    for (int x{0}; x < width_ + shifts_; x += lanes) {
      const auto here = next;
      next = load(x + lanes);
      std::uint8_t* const line{lines_ + 8 * x + 4 * row * lanes};
      hn::Store(low_half(here), d8, line);
      hn::Store(low_half(next), d8, line + lanes);
      hn::Store(high_half(here), d8, line + 2 * lanes);
      hn::Store(high_half(next), d8, line + 3 * lanes);
    }
    const auto times_4 = [&](V8 half) { return hn::Add(hn::Add(half, half), hn::Add(half, half)); };
    std::uint8_t* const low{left_ + 2 * row * left_length(width_)};
    std::uint8_t* const high{low + left_length(width_)};
    for (int u{0}; u < width_; u += lanes) {
      const auto here = hn::LoadU(d8, left + u);
      hn::StoreU(times_4(low_half(here)), d8, low + u);
      hn::StoreU(times_4(high_half(here)), d8, high + u);
    }
  }

  static HWY_INLINE V8 looked_up(V8 table, const Pixel& pixel, int part) {
    return hn::TableLookupBytes(table, hn::LoadU(Bytes{}, pixel.right + part * lanes));
  }
  static HWY_INLINE V8 low_half(V8 bytes) { return hn::And(bytes, hn::Set(Bytes{}, std::uint8_t{15})); }
  static HWY_INLINE V8 high_half(V8 bytes) {
    return low_half(hn::BitCast(Bytes{}, hn::ShiftRight<4>(hn::BitCast(Words{}, bytes))));
  }

  int width_;
  int shifts_;
  std::uint8_t* lines_;  // [x / lanes][row]: two vectors of low halves, two of high ones
  std::uint8_t* left_;   // [row][half][u]: place of the table / (lanes / 4)
};
#else
// Counts bits of bytes, which these instruction sets do in few instructions.
class DifferingBits {
 public:
  struct Pixel {
    V8 in;
    V8 out;
    const std::uint8_t* right_in;
    const std::uint8_t* right_out;
  };

  static constexpr int memory(int /*width*/, int /*shifts*/) { return 0; }

  DifferingBits(int width, int /*shifts*/, std::uint8_t* /*memory*/) : width_{width} {}

  void take_entering(const std::uint8_t* left, const std::uint8_t* right_reversed) { in_ = {left, right_reversed}; }
  void take_leaving(const std::uint8_t* left, const std::uint8_t* right_reversed) { out_ = {left, right_reversed}; }

  [[nodiscard]] HWY_INLINE const std::uint8_t* right(std::ptrdiff_t u) const {
    return in_.right_reversed + width_ - 1 - u;
  }
  [[nodiscard]] std::ptrdiff_t steady(std::ptrdiff_t u) const { return width_ - u; }

  [[nodiscard]] HWY_INLINE Pixel pixel(std::ptrdiff_t u, const std::uint8_t* right) const {
    return {hn::Set(Bytes{}, in_.left[u]), hn::Set(Bytes{}, out_.left[u]), right,
            right + (out_.right_reversed - in_.right_reversed)};
  }

  static HWY_INLINE V8 entering(const Pixel& pixel, int i) { return differing(pixel.in, pixel.right_in, i); }
  static HWY_INLINE V8 leaving(const Pixel& pixel, int i) { return differing(pixel.out, pixel.right_out, i); }

 private:
  struct Row {
    const std::uint8_t* left;
    const std::uint8_t* right_reversed;
  };
  static HWY_INLINE V8 differing(V8 left, const std::uint8_t* right, int i) {
    return hn::PopulationCount(hn::Xor(left, hn::LoadU(Bytes{}, right + i * bytes_of_vector)));
  }

  int width_;
  Row in_{};
  Row out_{};
};
#endif

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
