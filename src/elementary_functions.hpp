// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>

#include "host_device.hpp"

namespace stereogrid {

/// Natural logarithm of x ≥ ¾, to 1e-6; the same on all machines, and without branches.
STEREOGRID_HD inline float natural_log(float x) {
  std::uint32_t bits{};
  std::memcpy(&bits, &x, sizeof bits);
  const int shift{127 - static_cast<int>(bits >> 22 & 1U)};  // the mantissa to [¾, 1½)
  const int exponent{static_cast<int>(bits >> 23) - shift};
  bits = (bits & 0x7fffffU) | static_cast<std::uint32_t>(shift) << 23;
  float t{};
  std::memcpy(&t, &bits, sizeof t);
  t -= 1;
  // of least error from −¼ to ½
  const float part{
      1.0000009f +
      t * (-0.499986653f +
           t * (0.333143244f + t * (-0.250605507f + t * (0.206759358f + t * (-0.168271005f + t * 0.0831664767f)))))};
  return static_cast<float>(exponent) * 0.693147181f + t * part;
}

/// e^x for |x| ≤ 80, to a relative 1e-6; the same on all machines.
STEREOGRID_HD inline float exponential(float x) {
  const float halves{x * 1.44269504f};
  constexpr float rounding{12582912};  // 1.5·2^23: sums with it are whole numbers
  const float whole{(halves + rounding) - rounding};
  const float t{(halves - whole) * 0.693147181f};
  const float part{
      1 + t * (1 + t * (0.5f + t * (0.166666667f + t * (0.0416666667f + t * (0.00833333333f + t * 0.00138888889f)))))};
  const std::uint32_t bits{static_cast<std::uint32_t>(static_cast<int>(whole) + 127) << 23};
  float power{};
  std::memcpy(&power, &bits, sizeof power);
  return part * power;
}

}  // namespace stereogrid
