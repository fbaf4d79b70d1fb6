// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "matching/lanes.cuh"

namespace stereogrid {

using Word = std::uint32_t;

/// Numbers of 32 columns: a word for each binary digit, the lowest first.
template <int n>
struct Number {
  Word digits[n];
};

template <int n, int m>
__device__ inline Number<n> resized(const Number<m>& a) {
  static_assert(n <= m);
  Number<n> low;
  STEREOGRID_UNROLL
  for (int i = 0; i < n; ++i) low.digits[i] = a.digits[i];
  return low;
}

template <int n>
__device__ inline Number<n> operator~(const Number<n>& a) {
  Number<n> inverse;
  STEREOGRID_UNROLL
  for (int i = 0; i < n; ++i) inverse.digits[i] = ~a.digits[i];
  return inverse;
}

/// Numbers of the columns `by` further right.
template <int n>
__device__ inline Number<n> operator>>(const Number<n>& a, int by) {
  Number<n> shifted;
  STEREOGRID_UNROLL
  for (int i = 0; i < n; ++i) shifted.digits[i] = a.digits[i] >> by;
  return shifted;
}

/// a + b + carry: full adders. Missing digits of b are `rest`.
template <int n, int m>
__device__ inline Number<n + 1> sum(const Number<n>& a, const Number<m>& b, Word carry = 0, Word rest = 0) {
  static_assert(m <= n);
  Number<n + 1> s;
  STEREOGRID_UNROLL
  for (int i = 0; i < n; ++i) {
    const Word x{a.digits[i]};
    const Word y{i < m ? b.digits[i < m ? i : 0] : rest};
    s.digits[i] = x ^ y ^ carry;
    carry = (x & y) | (carry & (x | y));
  }
  s.digits[n] = carry;
  return s;
}

/// a − b by the complement; the highest digit is 1 where b <= a.
template <int n, int m>
__device__ inline Number<n + 1> difference(const Number<n>& a, const Number<m>& b) {
  return sum(a, ~b, ~0u, ~0u);
}

/// Number of bits that are set, by column.
__device__ inline Number<4> ones_of(const Word (&bit)[8]) {
  const auto sum3 = [&](int i) { return sum(Number<1>{{bit[i]}}, Number<1>{{bit[i + 1]}}, bit[i + 2]); };
  return resized<4>(sum(sum(sum3(0), sum3(3), bit[6]), Number<1>{{bit[7]}}));
}

/// A number in shared memory; `apart`: words between two digits.
template <int n, int apart>
__device__ inline Number<n> load(const Word* from) {
  Number<n> number;
  STEREOGRID_UNROLL
  for (int d = 0; d < n; ++d) number.digits[d] = from[d * apart];
  return number;
}
template <int apart, int n>
__device__ inline void store(const Number<n>& number, Word* to) {
  STEREOGRID_UNROLL
  for (int d = 0; d < n; ++d) to[d * apart] = number.digits[d];
}

}  // namespace stereogrid
