// SPDX-License-Identifier: Apache-2.0
//
// The road hypothesis of the double correlation, a row at a time, with vectors along the pixels: it has few shifts.
// Included once per instruction set by correlate_simd.cpp; the guard works per target.
#if defined(STEREOGRID_LEVEL_SIMD) == defined(HWY_TARGET_TOGGLE)
#ifdef STEREOGRID_LEVEL_SIMD
#undef STEREOGRID_LEVEL_SIMD
#else
#define STEREOGRID_LEVEL_SIMD
#endif

#include <algorithm>
#include <cstdint>

#include "hwy/highway.h"
#include "matching/correlation/rival_limit_simd.hpp"
#include "matching/correlation/simd.hpp"
#include "matching/window_sums_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

class LevelRows {
 public:
  LevelRows(int width, int half_window, int uniqueness_1024, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        uniqueness_1024_{uniqueness_1024},
        stride_{row_length(width, half_window)},
        boxes_{reinterpret_cast<std::uint16_t*>(memory)},
        differing_{memory + 2 * stride_ * count},
        fours_{differing_ + stride_ * count},
        rows_{fours_ + stride_ * count} {
    std::fill(memory, memory + LevelRows::memory(width, half_window), std::uint8_t{0});
  }

  static std::size_t memory(int width, int half_window) {
    return static_cast<std::size_t>(row_length(width, half_window)) *
           static_cast<std::size_t>(count * (4 + slots(half_window)));
  }

  void add_row(const std::uint8_t* left, const std::uint8_t* sheared) {
    sum_row(left, sheared);
    for (int u{0}; u < width_; u += lanes) move_boxes(u);
  }

  // Adds a row, and takes away the one that has left the window.
  void find_costs(const std::uint8_t* left, const std::uint8_t* sheared, CandidateRow& out) {
    sum_row(left, sheared);
    for (int u{0}; u < width_; u += lanes) {
      const Sums box{move_boxes(u)};
      auto cost = box.of[0];
      for (int k{1}; k < count; ++k) cost = hn::Min(cost, box.of[k]);
      hn::StoreU(cost, Words{}, out.cost() + u);
    }
  }

  // The rest of the candidates where they are cheaper than others; with vectors that run over.
  void compare_costs(const std::uint16_t* others, CandidateRow& out) const {
    const Words d16;
    for (int u{0}; u < width_; u += lanes) {
      if (hn::AllFalse(d16, hn::Lt(hn::LoadU(d16, out.cost() + u), hn::LoadU(d16, others + u)))) continue;
      Sums box;
      for (int k{0}; k < count; ++k) box.of[k] = hn::Load(d16, boxes_ + stride_ * k + u);
      compare_costs_at(box, u, out);
    }
  }

 private:
  static constexpr int count{road_shifts.count};
  static constexpr int margin{64};  // before a row's differing bits
  static constexpr int lanes{static_cast<int>(hn::MaxLanes(Words{}))};
  struct Sums {
    HWY_INLINE Sums() {}  // the compiler's own would not be compiled for the instruction set
    V16 of[count];
  };

  // columns of the window beyond both ends, and vectors that run over
  static int row_length(int width, int half_window) { return (width + 4 * half_window + 256) / 64 * 64; }
  // rows of the window, and the one that leaves it
  static int slots(int half_window) { return 2 * half_window + 2; }
  [[nodiscard]] std::uint8_t* row(int slot, int k) const { return rows_ + stride_ * (slot * count + k); }

  // Sums of a row's differing bits over the window's columns, to the slot after the last one. Each step goes over all
  // shifts: loads that overlap two vectors wait until both have left the store buffer.
  HWY_NOINLINE void sum_row(const std::uint8_t* left, const std::uint8_t* sheared) {
    const Bytes d8;
    constexpr int bytes{2 * lanes};
    slot_ = slot_ + 1 < slots(half_) ? slot_ + 1 : 0;
    const int width{width_};
    const int size{2 * half_ + 1};
    for (int k{0}; k < count; ++k) {
      const std::uint8_t* const right{sheared - (road_shifts.first + k)};
      std::uint8_t* const bits{differing_ + stride_ * k + margin};
#pragma GCC unroll 2
      for (int u{0}; u < width; u += bytes) {
        hn::StoreU(hn::PopulationCount(hn::Xor(hn::LoadU(d8, left + u), hn::LoadU(d8, right + u))), d8, bits + u);
      }
      const auto first = hn::Set(d8, bits[0]);
      const auto last = hn::Set(d8, bits[width - 1]);
      for (int i{0}; i < half_; i += bytes) {
        hn::StoreU(first, d8, bits - bytes - i);
        hn::StoreU(last, d8, bits + width + i);
      }
    }
    const auto columns_of = [&](int k) {
      return [d8, row = differing_ + stride_ * k + margin - half_](int u) { return hn::LoadU(d8, row + u); };
    };
    for (int k{0}; k < count; ++k) sums_of_fours(d8, columns_of(k), width, size, fours_ + stride_ * k);
    for (int k{0}; k < count; ++k) {
      std::uint8_t* const sums{row(slot_, k)};
      const auto store = [&](V8 of, int u) { hn::Store(of, d8, sums + u); };
      window_sums(d8, columns_of(k), width, size, fours_ + stride_ * k, store);
    }
  }

  // Adds the last row to the boxes and takes the one away that has left the window.
  HWY_INLINE Sums move_boxes(int u) const {
    const Words d16;
    const int oldest{slot_ + 1 < slots(half_) ? slot_ + 1 : 0};
    const auto load = [&](const std::uint8_t* sums) { return hn::PromoteTo(d16, hn::LoadU(hn::Half<Bytes>{}, sums)); };
    Sums box;
    for (int k{0}; k < count; ++k) {
      std::uint16_t* const at{boxes_ + stride_ * k + u};
      box.of[k] = hn::Add(hn::Load(d16, at), hn::Sub(load(row(slot_, k) + u), load(row(oldest, k) + u)));
      hn::Store(box.of[k], d16, at);
    }
    return box;
  }

  HWY_INLINE void compare_costs_at(const Sums& box, int u, CandidateRow& out) const {
    const Words d16;
    const auto set = [&](int value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
    Sums up_to;  // smallest of the shifts 0 … k
    Sums from;   // smallest of the shifts k … count − 1
    up_to.of[0] = box.of[0];
    from.of[count - 1] = box.of[count - 1];
    for (int k{1}; k < count; ++k) up_to.of[k] = hn::Min(up_to.of[k - 1], box.of[k]);
    for (int k{count - 2}; k >= 0; --k) from.of[k] = hn::Min(from.of[k + 1], box.of[k]);
    const auto cost = up_to.of[count - 1];
    auto shift = set(road_shifts.first + count - 1);
    auto before = cost;
    auto after = cost;
    auto second = up_to.of[count - 3];
    for (int k{count - 2}; k >= 0; --k) {
      const auto is_best = hn::Eq(box.of[k], cost);
      const auto choose = [&](V16 chosen, V16 other) { return hn::IfThenElse(is_best, chosen, other); };
      shift = choose(set(road_shifts.first + k), shift);
      before = choose(k > 0 ? box.of[k - 1] : cost, before);
      after = choose(k > 0 ? box.of[k + 1] : cost, after);
      const auto below = k > 1 ? up_to.of[k - 2] : set(65535);
      second = choose(k < count - 2 ? hn::Min(below, from.of[k + 2]) : below, second);
    }
    const auto has_rivals = hn::Lt(second, rival_limit(cost, uniqueness_1024_));
    hn::StoreU(hn::IfThenElseZero(has_rivals, set(1)), d16, out.has_rivals() + u);
    hn::StoreU(before, d16, out.before() + u);
    hn::StoreU(after, d16, out.after() + u);
    hn::StoreU(shift, d16, reinterpret_cast<std::uint16_t*>(out.shift()) + u);
  }

  int width_;
  int half_;
  int uniqueness_1024_;
  int slot_{0};  // the last row's
  std::ptrdiff_t stride_;
  std::uint16_t* boxes_;     // [shift][u]: costs
  std::uint8_t* differing_;  // [shift][margin + u]: differing bits of a row
  std::uint8_t* fours_;      // [shift][u]: sums of four columns
  std::uint8_t* rows_;       // [slot][shift][u]: differing bits summed over the window's columns
};

}  // namespace stereogrid::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
