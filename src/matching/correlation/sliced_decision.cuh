// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "matching/correlation/bit_slices.cuh"
#include "matching/cuda.hpp"

namespace stereogrid {

constexpr int cost_digits{10};  ///< cost of a window: at most 9 · 9 · 8

/// The best of `shifts` shifts in 32 columns, by a warp. A lane has `each` shifts. From the highest digit down, shifts
/// with a one drop out wherever one that is left has a zero: first the digits of the least cost, then those of its
/// first shift.
template <int shifts, int apart>
class Decision {
 public:
  /// `costs`: of shift 0; those of the others follow, digits lie `apart`. The first `count` shifts take part.
  __device__ Decision(const Word* costs, int count)
      : costs_{costs}, count_{count}, lane_{static_cast<int>(threadIdx.x) % 32} {
    STEREOGRID_UNROLL
    for (int d = 0; d < cost_digits; ++d) {
      const auto words = *reinterpret_cast<const Words*>(costs + d * apart + each * lane_ % shifts);
      STEREOGRID_UNROLL
      for (int i = 0; i < each; ++i) mine_[i].digits[d] = words.of[i];
    }
  }

  /// Lane k returns the label of column k.
  __device__ FoundLabel find(int uniqueness_1024) const {
    Word best[each];  // columns whose best shift this is
    STEREOGRID_UNROLL
    for (int i = 0; i < each; ++i) best[i] = is_shift(i);
    Number<cost_digits> cost;
    STEREOGRID_UNROLL
    for (int d = cost_digits - 1; d >= 0; --d) {
      cost.digits[d] = keep_least(best, [&](int i) { return mine_[i].digits[d]; });
    }
    Number<label_digits> label;
    STEREOGRID_UNROLL
    for (int d = label_digits - 1; d >= 0; --d) {
      label.digits[d] = keep_least(best, [&](int i) { return 0u - (static_cast<Word>(shift(i)) >> d & 1u); });
    }
    const int least{of_my_column(cost)};
    const int at{of_my_column(label)};
    const Word has_rivals{rivals(best, min(highest_rival(least, uniqueness_1024), (1 << cost_digits) - 1))};
    const bool inside{at > 0 && at < count_ - 1};
    return {static_cast<std::uint16_t>(least), cost_of(inside ? at - 1 : at), cost_of(inside ? at + 1 : at),
            static_cast<std::uint8_t>(at), static_cast<std::uint8_t>(has_rivals >> lane_ & 1u)};
  }

 private:
  static constexpr int each{shifts < 32 ? 1 : shifts / 32};
  static constexpr int label_digits{shifts == 128 ? 7 : (shifts == 64 ? 6 : 3)};
  static_assert(1 << label_digits == shifts);
  struct alignas(each * sizeof(Word)) Words {
    Word of[each];
  };

  __device__ int shift(int i) const { return each * lane_ + i; }
  __device__ Word is_shift(int i) const { return shift(i) < count_ ? ~0u : 0u; }

  // The least of a digit, by column; shifts with a greater one are left out.
  template <class Digit>
  __device__ Word keep_least(Word (&left)[each], const Digit& digit) const {
    Word zero{0};
    STEREOGRID_UNROLL
    for (int i = 0; i < each; ++i) zero |= left[i] & ~digit(i);
    zero = any_of_lanes(zero);
    STEREOGRID_UNROLL
    for (int i = 0; i < each; ++i) left[i] &= ~(digit(i) & zero);
    return ~zero;
  }

  // Columns where a shift that is neither the best one nor beside it costs no more than the column's limit.
  __device__ Word rivals(const Word (&best)[each], int my_limit) const {
    Number<cost_digits> limit;
    STEREOGRID_UNROLL
    for (int d = 0; d < cost_digits; ++d) limit.digits[d] = __ballot_sync(all_lanes, my_limit & 1 << d);
    Word around[each + 2];  // columns whose best shift is that before the lane's, one of the lane's, that behind them
    const Word before{__shfl_up_sync(all_lanes, best[each - 1], 1)};
    const Word behind{__shfl_down_sync(all_lanes, best[0], 1)};
    around[0] = lane_ == 0 ? 0u : before;
    around[each + 1] = lane_ == 31 ? 0u : behind;
    STEREOGRID_UNROLL
    for (int i = 0; i < each; ++i) around[i + 1] = best[i];
    Word found{0};
    STEREOGRID_UNROLL
    for (int i = 0; i < each; ++i) {
      found |=
          difference(limit, mine_[i]).digits[cost_digits] & is_shift(i) & ~(around[i] | around[i + 1] | around[i + 2]);
    }
    return any_of_lanes(found);
  }

  template <int n>
  __device__ int of_my_column(const Number<n>& number) const {
    Word value{0};
    STEREOGRID_UNROLL
    for (int d = 0; d < n; ++d) value = __funnelshift_r(value, number.digits[d] >> lane_, 1);
    return static_cast<int>(value >> (32 - n));
  }
  __device__ std::uint16_t cost_of(int label) const {
    return static_cast<std::uint16_t>(of_my_column(load<cost_digits, apart>(costs_ + label)));
  }

  const Word* costs_;
  int count_;
  int lane_;
  Number<cost_digits> mine_[each];
};

}  // namespace stereogrid
