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

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "hwy/highway.h"
#include "matching/correlation/rival_limit_simd.hpp"
#include "matching/correlation/simd.hpp"
#include "matching/minima_simd.hpp"
#include "matching/model.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A row's contest between both hypotheses.
struct Contest {
  // Whether an upright match of these costs may be accepted at u or the pixels after it.
  [[nodiscard]] HWY_INLINE bool is_open(V16 cost, int u) const {
    const Words d16;
    auto highest = hn::Set(d16, static_cast<std::uint16_t>(cost_limit));
    if (u >= road.begin && u + static_cast<int>(hn::Lanes(d16)) <= road.end) {
      highest = hn::Min(highest, hn::LoadU(d16, level_cost + u));
    }
    return !hn::AllFalse(d16, hn::Eq(hn::Min(cost, highest), cost));
  }

  const std::uint16_t* level_cost;
  Columns road;  // columns where the road hypothesis counts
  int cost_limit;
};

// Candidates of up to `shift_count` shifts, a multiple of `tile`. Sums are costs times `scale`, plus an eighth of the
// shift's place in its tile: the smallest sum of a tile and its lane modulo 8 give the first of the best shifts. It
// goes step by step, each for all pixels, without waits for values just written.
template <int shift_count, int tile_size>
class UprightBlock {
 public:
  static constexpr int pixels{32};
  static constexpr int n{shift_count};
  static constexpr int tile{tile_size};
  static constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};
  static constexpr int vectors{n / lanes};
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
    for (int i{0}; i < tiles; ++i) {
      const int first{i * vectors / tiles};
      auto least = box.part[first];
      for (int k{first}; k < first + vectors / tiles; ++k) {
        hn::Store(box.part[k], d16, sums + k * lanes);
        least = hn::Min(least, box.part[k]);
      }
      least_[i][pixel] = static_cast<std::int32_t>(minimum16_and_position(folded(d16, least)));
    }
  }

  // Candidates of the first `count` pixels, to u and on; with vectors that run over.
  HWY_INLINE void finish(int u, int count, const Contest& contest, CandidateRow& out) {
    if constexpr (tiles > 1) join_tiles();
    bool decides[groups];
    for (int i{0}; i < groups; ++i) decides[i] = find_costs(i * lanes, u + i * lanes, contest, out);
    const auto where_it_decides = [&](const auto& step) {
      for (int i{0}; i < groups; ++i) {
        if (decides[i]) step(i * lanes, std::min((i + 1) * lanes, count));
      }
    };
    where_it_decides([&](int first, int end) { mask_least(first, end); });
    where_it_decides([&](int first, int end) { find_second(first, end); });
    where_it_decides([&](int first, int) { compare_costs(first, u + first, out); });
  }

 private:
  static constexpr int groups{pixels / lanes};
  static constexpr int tiles{n / tile};
  static constexpr int stride{n + lanes};
  static constexpr int scale_bits{std::countr_zero(scale)};

  [[nodiscard]] std::uint16_t* sums_of(int pixel) { return sums_ + lanes + pixel * stride; }

  static HWY_INLINE V16 cost_of(V16 sums) { return hn::ShiftRight<scale_bits>(sums); }

  // The first tile's smallest sums become those of all.
  void join_tiles() {
    const hn::ScalableTag<std::int32_t> d32;
    const auto cost = [&](auto sums) {
      return hn::ShiftRight<scale_bits>(hn::And(sums, hn::Set(d32, std::int32_t{65535})));
    };
    for (int pixel{0}; pixel < pixels; pixel += static_cast<int>(hn::Lanes(d32))) {
      auto least = hn::Load(d32, least_[0] + pixel);
      for (int i{1}; i < tiles; ++i) {
        const auto of_tile = hn::Add(hn::Load(d32, least_[i] + pixel), hn::Set(d32, (i * tile) << 16));
        least = hn::IfThenElse(hn::Lt(cost(of_tile), cost(least)), of_tile, least);
      }
      hn::Store(least, d32, least_[0] + pixel);
    }
  }

  // Stores the best sums and those beside them, and takes them out of the search.
  void mask_least(int first, int end) {
    const hn::ScalableTag<std::int32_t> d32;
    constexpr int at_once{static_cast<int>(hn::MaxLanes(d32))};
    auto before_shift_0 = hn::Mul(hn::Iota(d32, first), hn::Set(d32, stride));
    before_shift_0 = hn::Add(before_shift_0, hn::Set(d32, lanes - 1));
    alignas(64) std::int32_t places[lanes];
    for (int pixel{first}; pixel < first + lanes; pixel += at_once) {
      const auto least = hn::Load(d32, least_[0] + pixel);
      const auto eighths = hn::ShiftLeft<3>(hn::And(least, hn::Set(d32, std::int32_t{scale - 1})));
      hn::Store(hn::Add(hn::Add(before_shift_0, eighths), hn::ShiftRight<16>(least)), d32, places + pixel - first);
      before_shift_0 = hn::Add(before_shift_0, hn::Set(d32, at_once * stride));
    }
#pragma GCC unroll 4
    for (int pixel{first}; pixel < end; ++pixel) {
      std::uint16_t* const from{sums_ + places[pixel - first]};
      std::uint64_t around;
      std::memcpy(&around, from, sizeof around);
      around_[pixel] = around;
      around |= 0xffffffffffff;
      std::memcpy(from, &around, sizeof around);
    }
  }

  void find_second(int first, int end) {
    const Words d16;
#pragma GCC unroll 2
    for (int pixel{first}; pixel < end; ++pixel) {
      const std::uint16_t* const sums{sums_of(pixel)};
      auto least = hn::Load(d16, sums);
      for (int i{1}; i < vectors; ++i) least = hn::Min(least, hn::Load(d16, sums + i * lanes));
      second_[pixel] = hn::ExtractLane(minimum16(folded(d16, least)), 0);
    }
  }

  // Costs and shifts of some pixels; returns whether the rest of their candidates matters.
  HWY_INLINE bool find_costs(int pixel, int u, const Contest& contest, CandidateRow& out) const {
    const Words d16;
    const auto least = [&](int part) {
      return hn::Load(d16, reinterpret_cast<const std::uint16_t*>(least_[0] + pixel) + part * lanes);
    };
    const auto best = hn::ConcatEven(d16, least(1), least(0));
    const auto place = hn::ConcatOdd(d16, least(1), least(0));
    const auto cost = cost_of(best);
    hn::StoreU(cost, d16, out.cost() + u);
    const auto eighths = hn::And(best, hn::Set(d16, std::uint16_t{scale - 1}));
    hn::StoreU(hn::Add(place, hn::ShiftLeft<3>(eighths)), d16, reinterpret_cast<std::uint16_t*>(out.shift()) + u);
    return contest.is_open(cost, u);
  }

  // The rest of the candidates.
  HWY_INLINE void compare_costs(int pixel, int u, CandidateRow& out) const {
    const Words d16;
    const auto set = [&](unsigned value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
    const auto around = [&](int part) {
      return hn::Load(d16, reinterpret_cast<const std::uint16_t*>(around_ + pixel) + part * lanes);
    };
    const auto low = hn::ConcatEven(d16, around(1), around(0));
    const auto high = hn::ConcatEven(d16, around(3), around(2));
    const auto cost = hn::LoadU(d16, out.cost() + u);
    const auto shift = hn::LoadU(d16, reinterpret_cast<const std::uint16_t*>(out.shift()) + u);
    // no sum reaches 65535 − scale, but masked ones do
    const auto limit = hn::Min(rival_limit(cost, uniqueness_1024_), set(65535 >> scale_bits));
    const auto has_rivals = hn::Lt(hn::Load(d16, second_ + pixel), hn::ShiftLeft<scale_bits>(limit));
    const auto at_end = hn::Or(hn::Eq(shift, set(0)), hn::Eq(shift, set(static_cast<unsigned>(shifts_.count - 1))));
    const auto store = [&](V16 values, std::uint16_t* to) { hn::StoreU(values, d16, to + u); };
    store(hn::IfThenElseZero(has_rivals, set(1)), out.has_rivals());
    store(hn::IfThenElse(at_end, cost, cost_of(hn::ConcatEven(d16, high, low))), out.before());
    store(hn::IfThenElse(at_end, cost, cost_of(hn::ConcatOdd(d16, high, low))), out.after());
  }

  Shifts shifts_;
  int uniqueness_1024_;
  alignas(64) std::uint16_t sums_[pixels * stride + lanes]{};  // [pixel][shift], with space around each pixel's
  alignas(64) std::int32_t least_[tiles][pixels]{};            // smallest sum | its place less eighths << 16
  alignas(64) std::uint64_t around_[pixels]{};                 // sums before, at and after its shift
  alignas(64) std::uint16_t second_[pixels]{};                 // smallest sum elsewhere
};

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
