// SPDX-FileCopyrightText: 2026 The stereogrid authors
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
#include "matching/correlation/correlate_simd.hpp"
#include "matching/correlation/rival_limit_simd.hpp"
#include "matching/window_sums_simd.hpp"

HWY_BEFORE_NAMESPACE();
namespace stereogrid {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

class LevelRows {
 public:
  LevelRows(int width, Shifts shifts, int half_window, int uniqueness_1024, std::uint8_t* memory)
      : width_{width},
        half_{half_window},
        shifts_{shifts},
        uniqueness_1024_{uniqueness_1024},
        stride_{row_length(width, half_window)},
        power_{reinterpret_cast<std::uint16_t*>(memory)},
        boxes_{power_ + stride_},
        columns_{reinterpret_cast<std::uint8_t*>(boxes_ + stride_ * shifts.count)} {
    std::fill(columns_, columns_ + stride_ * shifts.count, std::uint8_t{0});
  }

  static std::size_t memory(int width, Shifts shifts, int half_window) {
    return static_cast<std::size_t>(row_length(width, half_window)) * static_cast<std::size_t>(2 + 3 * shifts.count);
  }

  // Adds the differing bits of one row to the columns' sums and takes those of another away (null: none).
  void update(const std::uint8_t* left, const std::uint8_t* sheared, const std::uint8_t* old_left,
              const std::uint8_t* old_sheared) {
    const hn::ScalableTag<std::uint8_t> d8;
    const int lanes{static_cast<int>(hn::Lanes(d8))};
    for (int k{0}; k < shifts_.count; ++k) {
      const int shift{shifts_.first + k};
      std::uint8_t* sums{columns(k) + half_};
      for (int u{0}; u < width_; u += lanes) {
        const auto differing = [&](const std::uint8_t* a, const std::uint8_t* b) {
          return hn::PopulationCount(hn::Xor(hn::LoadU(d8, a + u), hn::LoadU(d8, b + u - shift)));
        };
        auto sum = hn::Add(hn::LoadU(d8, sums + u), differing(left, sheared));
        if (old_left != nullptr) sum = hn::Sub(sum, differing(old_left, old_sheared));
        hn::StoreU(sum, d8, sums + u);
      }
    }
  }

  void finish_row(CandidateRow& out) {
    for (int k{0}; k < shifts_.count; ++k) sum_window(k);
    const hn::ScalableTag<std::uint16_t> d16;
    const int lanes{static_cast<int>(hn::Lanes(d16))};
    for (int u{0}; u < width_; u += lanes) find_best(u, out);
  }

 private:
  // columns of the window beyond both ends, and vectors that run over
  static int row_length(int width, int half_window) { return (width + 4 * half_window + 256) / 64 * 64; }
  [[nodiscard]] std::uint8_t* columns(int k) const { return columns_ + stride_ * k; }
  [[nodiscard]] std::uint16_t* box(int k) const { return boxes_ + stride_ * k; }

  void sum_window(int k) const {
    const hn::ScalableTag<std::uint16_t> d16;
    const hn::Rebind<std::uint8_t, decltype(d16)> d8;
    std::uint8_t* sums{columns(k)};
    std::fill(sums, sums + half_, sums[half_]);
    std::fill(sums + half_ + width_, sums + 2 * half_ + width_, sums[half_ + width_ - 1]);
    const auto load = [&](int u) { return hn::PromoteTo(d16, hn::LoadU(d8, sums + u)); };
    window_sums(d16, load, width_, 2 * half_ + 1, power_, box(k));
  }

  void find_best(int u, CandidateRow& out) const {
    const hn::ScalableTag<std::uint16_t> d16;
    const auto set = [&](int value) { return hn::Set(d16, static_cast<std::uint16_t>(value)); };
    const int count{shifts_.count};
    auto cost = set(65535);
    auto best = set(0);
    auto before = cost;
    auto after = cost;
    for (int k{0}; k < count; ++k) {
      const auto here = hn::LoadU(d16, box(k) + u);
      const bool inside{k > 0 && k < count - 1};
      const auto better = hn::Lt(here, cost);
      best = hn::IfThenElse(better, set(k), best);
      before = hn::IfThenElse(better, inside ? hn::LoadU(d16, box(k - 1) + u) : here, before);
      after = hn::IfThenElse(better, inside ? hn::LoadU(d16, box(k + 1) + u) : here, after);
      cost = hn::Min(cost, here);
    }
    const auto limit = rival_limit(d16, cost, uniqueness_1024_);
    auto rivals = set(0);
    for (int k{0}; k < count; ++k) {
      const auto is_far = hn::Gt(hn::Sub(set(k + 1), best), set(2));  // wraps round
      const auto is_close = hn::Lt(hn::LoadU(d16, box(k) + u), limit);
      rivals = hn::Or(rivals, hn::IfThenElseZero(hn::And(is_far, is_close), set(1)));
    }
    hn::StoreU(cost, d16, out.cost() + u);
    hn::StoreU(rivals, d16, out.has_rivals() + u);
    hn::StoreU(before, d16, out.before() + u);
    hn::StoreU(after, d16, out.after() + u);
    const auto shift = hn::Add(best, set(shifts_.first));
    hn::StoreU(shift, d16, reinterpret_cast<std::uint16_t*>(out.shift()) + u);
  }

  int width_;
  int half_;
  Shifts shifts_;
  int uniqueness_1024_;
  std::ptrdiff_t stride_;
  std::uint16_t* power_;   // [u]: sums of 2, 4, 8 … columns
  std::uint16_t* boxes_;   // [shift][u]: costs
  std::uint8_t* columns_;  // [shift][half_window + u]: differing bits summed over the window's rows
};

}  // namespace HWY_NAMESPACE
}  // namespace stereogrid
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
