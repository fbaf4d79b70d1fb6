// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>

namespace stereogrid {

/// exp(x) for −80 ≤ x ≤ 0; smaller x are clamped. Relative error below 1e-5. The same bits on every platform, and
/// vectorised by compilers.
inline float exp_of(float x) {
  constexpr float log2_e{1.44269504F};
  const float scaled{(x < -80 ? -80 : x) * log2_e};
  const int whole{static_cast<int>(scaled)};
  const float f{scaled - static_cast<float>(whole)};  // −1 < f ≤ 0
  // Chebyshev approximation of 2^f
  const float power{0.9999981F + f * (0.6930507F + f * (0.23943922F + f * (0.05322683F + f * 0.00684199F)))};
  return power * std::bit_cast<float>((whole + 127) << 23);
}

/// Natural logarithm of a normal positive number. Absolute error below 2e-5.
inline float ln_of(float x) {
  constexpr float ln_2{0.69314718F};
  const std::int32_t bits{std::bit_cast<std::int32_t>(x)};
  const float t{std::bit_cast<float>((bits & 0x007fffff) | 0x3f800000) - 1};  // 0 ≤ t < 1
  // Chebyshev approximation of ln(1 + t)/t
  const float series{0.99999183F +
                     t * (-0.4993726F + t * (0.32529515F + t * (-0.2102937F + t * (0.10150005F - t * 0.02397957F))))};
  return static_cast<float>((bits >> 23) - 127) * ln_2 + t * series;
}

/// 1/√x of a normal positive number. Relative error below 1e-5.
inline float inverse_root_of(float x) {
  float y{std::bit_cast<float>(0x5f375a86 - (std::bit_cast<std::int32_t>(x) >> 1))};
  for (int round{0}; round < 2; ++round) y = y * (1.5F - 0.5F * x * y * y);
  return y;
}

}  // namespace stereogrid
