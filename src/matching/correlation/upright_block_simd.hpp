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

#include <bit>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "matching/correlation/correlate_simd.hpp"
#include "matching/correlation/rival_limit_simd.hpp"
#include "matching/minima_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Candidates of up to 64 times `words` shifts. Sums are costs times `scale`, plus an eighth of the shift's place in its
// tile: the smallest sum of a tile and its lane modulo 8 give the first of the best shifts. It goes step by step, each
// for all pixels, without waits for values just written.
template <int words, bool is_tiled>
class UprightBlock {
 public:
  static constexpr int pixels{32};
  static constexpr int n{64 * words};  // shifts with padding
  static constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};
  static constexpr int vectors{n / lanes};
  static constexpr int tile{is_tiled ? 32 : n};  // shifts whose sums are compared with each other
  static constexpr unsigned scale{std::bit_ceil(tile / 8u)};

  // Whether sums fit in 16 bits.
  static constexpr bool holds(int cost_max) { return scale * (static_cast<unsigned>(cost_max) + 1) <= 65536; }
  static std::uint16_t first_sum(int shift) { return static_cast<std::uint16_t>(shift % tile / 8); }

  // Window sums of a pixel.
  struct Sums {
    HWY_INLINE Sums() {}  // the compiler's own would not be compiled for the instruction set
    V16 part[vectors];
  };

  UprightBlock(Shifts shifts, int uniqueness_1024) : shifts_{shifts}, uniqueness_1024_{uniqueness_1024} {}

  // Sums of a pixel of the block.
  HWY_INLINE void take(const Sums& box, int pixel) {
    const Words d16;
    std::uint16_t* const sums{sums_of(pixel)};
    auto least = box.part[0];
    for (int i{0}; i < vectors; ++i) {
      hn::Store(box.part[i], d16, sums + i * lanes);
      least = hn::Min(least, box.part[i]);
    }
    if constexpr (!is_tiled) least_[pixel] = minimum16_and_position(folded(d16, least));
  }

  // Candidates of the first `count` pixels, to u and on; with vectors that run over.
  HWY_INLINE void finish(int u, int count, CandidateRow& out) {
    if constexpr (is_tiled) join_tiles(count);
    mask_least(count);
    find_second(count);
    for (int i{0}; i < pixels; i += lanes) candidates_at(i, u + i, out);
  }

 private:
  static constexpr int stride{n + lanes};
  static constexpr int scale_bits{std::countr_zero(scale)};

  [[nodiscard]] std::uint16_t* sums_of(int pixel) { return sums_ + lanes + pixel * stride; }

  void join_tiles(int count) {
    const Words d16;
    for (int pixel{0}; pixel < count; ++pixel) {
      std::uint32_t least{65535};
      for (int first{0}; first < n; first += tile) {
        auto least_of_tile = hn::Load(d16, sums_of(pixel) + first);
        for (int i{lanes}; i < tile; i += lanes) {
          least_of_tile = hn::Min(least_of_tile, hn::Load(d16, sums_of(pixel) + first + i));
        }
        const std::uint32_t found{minimum16_and_position(folded(d16, least_of_tile))};
        const bool is_less{(found & 65535) / scale < (least & 65535) / scale};
        least = is_less ? found + (static_cast<std::uint32_t>(first) << 16) : least;
      }
      least_[pixel] = least;
    }
  }

  // Stores the best shifts and the sums beside them, and takes these out of the search.
  void mask_least(int count) {
    for (int pixel{0}; pixel < count; ++pixel) {
      const std::uint32_t least{least_[pixel]};
      const std::uint32_t shift{8 * (least % scale) + (least >> 16)};
      std::uint16_t* const from{sums_of(pixel) + shift - 1};
      std::uint64_t around;
      std::memcpy(&around, from, sizeof around);
      best_[pixel] = static_cast<std::uint16_t>(least);
      shift_[pixel] = static_cast<std::uint16_t>(shift);
      before_[pixel] = static_cast<std::uint16_t>(around);
      after_[pixel] = static_cast<std::uint16_t>(around >> 32);
      around |= 0xffffffffffff;
      std::memcpy(from, &around, sizeof around);
    }
  }

  void find_second(int count) {
    const Words d16;
    for (int pixel{0}; pixel < count; ++pixel) {
      const std::uint16_t* const sums{sums_of(pixel)};
      auto least = hn::Load(d16, sums);
      for (int i{1}; i < vectors; ++i) least = hn::Min(least, hn::Load(d16, sums + i * lanes));
      second_[pixel] = hn::GetLane(minimum16(folded(d16, least)));
    }
  }

  HWY_INLINE void candidates_at(int pixel, int u, CandidateRow& out) const {
    const Words d16;
    const auto set = [&](unsigned value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
    const auto load_cost = [&](const std::uint16_t* sums) {
      return hn::ShiftRight<scale_bits>(hn::Load(d16, sums + pixel));
    };
    const auto cost = load_cost(best_);
    const auto shift = hn::Load(d16, shift_ + pixel);
    // no sum reaches 65535 − scale, but masked ones do
    const auto limit = hn::Min(rival_limit(cost, uniqueness_1024_), set(65535 >> scale_bits));
    const auto has_rivals = hn::Lt(hn::Load(d16, second_ + pixel), hn::ShiftLeft<scale_bits>(limit));
    const auto at_end = hn::Or(hn::Eq(shift, set(0)), hn::Eq(shift, set(static_cast<unsigned>(shifts_.count - 1))));
    const auto store = [&](V16 values, std::uint16_t* to) { hn::StoreU(values, d16, to + u); };
    store(cost, out.cost());
    store(hn::IfThenElseZero(has_rivals, set(1)), out.has_rivals());
    store(hn::IfThenElse(at_end, cost, load_cost(before_)), out.before());
    store(hn::IfThenElse(at_end, cost, load_cost(after_)), out.after());
    store(shift, reinterpret_cast<std::uint16_t*>(out.shift()));
  }

  Shifts shifts_;
  int uniqueness_1024_;
  alignas(64) std::uint16_t sums_[pixels * stride + lanes]{};  // [pixel][shift], with space around each pixel's
  alignas(64) std::uint32_t least_[pixels];                    // smallest sum | its place less eighths << 16
  alignas(64) std::uint16_t best_[pixels]{};                   // smallest sum
  alignas(64) std::uint16_t shift_[pixels]{};                  // its shift
  alignas(64) std::uint16_t before_[pixels]{};                 // sums beside it
  alignas(64) std::uint16_t after_[pixels]{};
  alignas(64) std::uint16_t second_[pixels]{};  // smallest sum elsewhere
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
