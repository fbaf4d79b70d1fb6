// SPDX-License-Identifier: Apache-2.0
#pragma once

// Operations on single numbers under the names that Highway has for vectors of them: a formula that uses these, and the
// arithmetic operators, is a template for both. What Highway has no name for, numbers_simd.hpp adds.
#include <cstdint>
#include <cstring>

#include "host_device.hpp"

namespace stereogrid {

STEREOGRID_HD inline float Min(float a, float b) {
  return b < a ? b : a;
}
STEREOGRID_HD inline float Max(float a, float b) {
  return a < b ? b : a;
}
STEREOGRID_HD inline int Min(int a, int b) {
  return b < a ? b : a;
}
STEREOGRID_HD inline int Max(int a, int b) {
  return a < b ? b : a;
}
STEREOGRID_HD inline int Abs(int a) {
  return a < 0 ? -a : a;
}
STEREOGRID_HD inline float Abs(float a) {
  return a < 0 ? -a : a;
}
STEREOGRID_HD inline bool And(bool a, bool b) {
  return a && b;
}
STEREOGRID_HD inline bool Or(bool a, bool b) {
  return a || b;
}
STEREOGRID_HD inline int IfThenElse(bool chosen, int yes, int no) {
  return chosen ? yes : no;
}
STEREOGRID_HD inline float IfThenElse(bool chosen, float yes, float no) {
  return chosen ? yes : no;
}
STEREOGRID_HD inline float IfThenElseZero(bool chosen, float yes) {
  return chosen ? yes : 0.0f;
}

/// `value` as a number of the kind of the first.
STEREOGRID_HD inline int number(int /*like*/, int value) {
  return value;
}
STEREOGRID_HD inline float number(float /*like*/, float value) {
  return value;
}

STEREOGRID_HD inline float real(int value) {
  return static_cast<float>(value);
}
/// Truncates to an integer.
STEREOGRID_HD inline int whole(float value) {
  return static_cast<int>(value);
}

/// A condition as one on numbers of the kind of the first.
template <class T>
STEREOGRID_HD inline bool condition(T /*like*/, bool value) {
  return value;
}

/// `from` − half of x's bits as an integer, seen as a float.
STEREOGRID_HD inline float less_half_of_bits(std::uint32_t from, float x) {
  std::uint32_t bits{0};
  std::memcpy(&bits, &x, sizeof(bits));
  bits = from - (bits >> 1);
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}

/// Exponent for which a normal x > 0 is mantissa_of(x, exponent_of(x)) · 2^exponent_of(x), with a mantissa from ¾ to
/// 1½.
STEREOGRID_HD inline int exponent_of(float x) {
  std::uint32_t bits{0};
  std::memcpy(&bits, &x, sizeof(bits));
  return static_cast<int>((bits >> 23) + (bits >> 22 & 1U)) - 127;
}
STEREOGRID_HD inline float mantissa_of(float x, int exponent) {
  std::uint32_t bits{0};
  std::memcpy(&bits, &x, sizeof(bits));
  bits -= static_cast<std::uint32_t>(exponent) << 23;
  std::memcpy(&x, &bits, sizeof(x));
  return x;
}

/// 2^exponent; whole, from −126 to 127.
STEREOGRID_HD inline float power_of_two(float exponent) {
  const std::uint32_t bits{static_cast<std::uint32_t>(static_cast<int>(exponent) + 127) << 23};
  float power{0};
  std::memcpy(&power, &bits, sizeof(power));
  return power;
}

#include "number_formulas.hpp"

}  // namespace stereogrid
